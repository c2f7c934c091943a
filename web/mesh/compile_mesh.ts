import { compiledOnce } from "../core/compile_asset.ts";
import type { CompiledModule } from "../core/instantiate.ts";

/** Compiles the module once; after a failure, the next call tries again. */
export const compileMesh: () => Promise<CompiledModule> = compiledOnce(
  "isosplat-mesh.wasm",
  () => new URL("../../build/wasm/web/isosplat-mesh.wasm", import.meta.url),
);
