/** The store that write_store_fixture.cpp writes. */
import { existsSync, readFileSync } from "node:fs";

const built = new URL("../../build/", import.meta.url);

/** The store of the first CMake preset in which the tests were built. */
export function storeBytes(): Uint8Array {
  for (const preset of ["release", "debug", "sanitizers"]) {
    const file = new URL(`${preset}/tests/shared/fixture.isosplat`, built);
    if (existsSync(file)) return new Uint8Array(readFileSync(file));
  }
  throw new Error("build/release/tests/shared/fixture.isosplat is missing: npm run build");
}
