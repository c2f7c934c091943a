/**
 * Builds the npm package: build/npm/package, and of it the tarball build/npm/isosplat-VERSION.tgz.
 *
 *     npm run build:package
 *
 * Needs the WebAssembly modules (npm run build -- wasm). One output file for each source file: a
 * bundle would have to keep `new URL(…, import.meta.url)` as it is, by which browsers, Node and
 * bundlers find the modules and the worker.
 */
import { execFileSync } from "node:child_process";
import {
  copyFileSync,
  cpSync,
  existsSync,
  mkdirSync,
  readdirSync,
  readFileSync,
  rmSync,
  writeFileSync,
} from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

const root = fileURLToPath(new URL("..", import.meta.url));
const output = join(root, "build/npm");
const folder = join(output, "package");
const wasm = join(root, "build/wasm/web");
const wasmFiles = [
  "isosplat-core.js",
  "isosplat-core.wasm",
  "isosplat-mesh.js",
  "isosplat-mesh.wasm",
  "isosplat-renderer.js",
  "isosplat-renderer.wasm",
  "layouts.js",
];

for (const file of wasmFiles) {
  if (!existsSync(join(wasm, file))) {
    throw new Error(`expected ${join(wasm, file)}, found none: run npm run build -- wasm`);
  }
}
rmSync(output, { recursive: true, force: true });
execFileSync(join(root, "node_modules/.bin/tsc"), ["-p", join(root, "web/npm")], {
  stdio: "inherit",
});

const emitted = readdirSync(folder, { recursive: true, encoding: "utf8" }).filter((file) =>
  /\.(js|d\.ts)$/.test(file),
);
// Before the check below, which expects that what is referred to exists.
mkdirSync(join(folder, "wasm"));
for (const file of wasmFiles) copyFileSync(join(wasm, file), join(folder, "wasm", file));
writeFileSync(join(folder, "wasm/layouts.d.ts"), layoutsDeclarations());
for (const file of emitted) fitReferences(join(folder, file));

copyFileSync(join(root, "LICENSE"), join(folder, "LICENSE"));
for (const file of ["README.md", "THIRD_PARTY_LICENSES.md"]) {
  copyFileSync(join(root, "web/npm", file), join(folder, file));
}
cpSync(join(root, "web/npm/python"), join(folder, "python"), {
  recursive: true,
  filter: (file) => !file.includes("__pycache__"),
});
const { version } = readJson(join(root, "package.json"));
const pyproject = join(folder, "python/pyproject.toml");
writeFileSync(
  pyproject,
  readFileSync(pyproject, "utf8").replace(/^version = .*$/m, `version = "${version}"`),
);
const { name, ...manifest } = readJson(join(root, "web/npm/package.json"));
writeFileSync(
  join(folder, "package.json"),
  `${JSON.stringify({ name, version, ...manifest }, null, 2)}\n`,
);

execFileSync("npm", ["pack", "--silent", "--pack-destination", output], {
  cwd: folder,
  stdio: ["ignore", "ignore", "inherit"],
});
console.log(join(output, `${name}-${version}.tgz`));

/**
 * Sources name each other with .ts, and the modules where CMake puts them. TypeScript rewrites
 * neither in declarations and in `new URL`.
 */
function fitReferences(file) {
  const text = readFileSync(file, "utf8")
    .replaceAll("../../build/wasm/web/", "../wasm/")
    .replaceAll(/"(\.\.?\/[^"\n]+)\.ts"/g, '"$1.js"');
  for (const [, reference = ""] of text.matchAll(/"(\.\.?\/[^"\n]+\.(?:js|wasm))"/g)) {
    if (!existsSync(join(dirname(file), reference))) {
      throw new Error(`${file}: expected ${reference} in the package, found none`);
    }
  }
  writeFileSync(file, text);
}

/** The declarations of layouts.js as those of a module; in the sources they name it by a pattern. */
function layoutsDeclarations() {
  const text = readFileSync(join(root, "web/core/generated.d.ts"), "utf8");
  const [, before, declarations] = text.match(/^(.*?)declare module "[^"]*" \{\n(.*)\}\n$/s) ?? [];
  if (!declarations) throw new Error("expected one declared module in web/core/generated.d.ts");
  return before + declarations.replaceAll(/^ {2}/gm, "");
}

function readJson(file) {
  return JSON.parse(readFileSync(file, "utf8"));
}
