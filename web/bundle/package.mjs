/**
 * Builds the npm package in build/npm/package, and packs it into build/npm/isosplat-VERSION.tgz.
 *
 *     npm run build:package
 *
 * It needs the WebAssembly modules (npm run build -- wasm). Each source file becomes one output file, so
 * that the expressions `new URL(…, import.meta.url)` stay valid: browsers, Node and bundlers find the
 * folder `assets` by them. `assets` contains the files that are fetched at run time: the WebAssembly
 * modules and the workers. Each worker is one file without imports, so that all bundlers can process it,
 * and users can copy it.
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
import { build } from "vite";

const root = fileURLToPath(new URL("../..", import.meta.url));
const output = join(root, "build/npm");
const folder = join(output, "package");
const wasm = join(root, "build/wasm/web");
const modules = ["isosplat-core", "isosplat-mesh", "isosplat-renderer"];
const scripts = [...modules.map((name) => `${name}.js`), "layouts.js"];
const workers = ["stream/decode_worker", "mesh/mesh_worker"];
/** Files beside the folders, for tools that do not read `exports`, and the module that each re-exports. */
const entries = {
  index: "element/all",
  anywidget: "element/anywidget",
  react: "element/react",
  svelte: "element/svelte",
  vue: "element/vue",
};

for (const file of [...modules.map((name) => `${name}.wasm`), ...scripts]) {
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
// Created before the check below, which expects that all files and folders that are named exist.
mkdirSync(join(folder, "wasm"));
mkdirSync(join(folder, "assets"));
for (const file of scripts) copyFileSync(join(wasm, file), join(folder, "wasm", file));
for (const name of modules) {
  copyFileSync(join(wasm, `${name}.wasm`), join(folder, "assets", `${name}.wasm`));
}
for (const worker of workers) await buildWorker(worker);
writeFileSync(join(folder, "wasm/layouts.d.ts"), layoutsDeclarations());
for (const file of emitted) fitReferences(join(folder, file));
for (const [name, module] of Object.entries(entries)) {
  const isDefault = readFileSync(join(folder, `${module}.js`), "utf8").includes("export default");
  const text = `export * from "./${module}.js";\n${isDefault ? `export { default } from "./${module}.js";\n` : ""}`;
  for (const ending of ["js", "d.ts"]) writeFileSync(join(folder, `${name}.${ending}`), text);
}

copyFileSync(join(root, "LICENSE"), join(folder, "LICENSE"));
for (const file of ["README.md", "THIRD_PARTY_LICENSES.md"]) {
  copyFileSync(join(root, "web/npm", file), join(folder, file));
}
cpSync(join(root, "web/npm/python"), join(folder, "python"), {
  recursive: true,
  filter: (file) => !file.includes("__pycache__"),
});
const { version, repository, homepage, bugs } = readJson(join(root, "package.json"));
const pyproject = join(folder, "python/pyproject.toml");
writeFileSync(
  pyproject,
  readFileSync(pyproject, "utf8").replace(/^version = .*$/m, `version = "${version}"`),
);
const { name, ...manifest } = readJson(join(root, "web/npm/package.json"));
writeFileSync(
  join(folder, "package.json"),
  `${JSON.stringify({ name, version, repository, homepage, bugs, ...manifest }, null, 2)}\n`,
);

execFileSync("npm", ["pack", "--silent", "--pack-destination", output], {
  cwd: folder,
  stdio: ["ignore", "ignore", "inherit"],
});
console.log(join(output, `${name}-${version}.tgz`));

/** Writes assets/NAME.js: the worker with all that it imports. */
async function buildWorker(worker) {
  const [, name] = worker.split("/");
  await build({
    configFile: false,
    logLevel: "warn",
    publicDir: false,
    build: {
      outDir: join(folder, "assets"),
      emptyOutDir: false,
      target: "es2022",
      lib: {
        entry: join(root, "web", `${worker}.ts`),
        formats: ["es"],
        fileName: () => `${name}.js`,
      },
      // Names stay as in the sources: Turbopack refuses a function in a block with the name of a parameter.
      rolldownOptions: {
        output: { codeSplitting: false, minify: { compress: true, mangle: false } },
      },
    },
  });
  const text = readFileSync(join(folder, "assets", `${name}.js`), "utf8");
  const [found] = text.match(/\bimport\b[^;]*|\bnew URL\b[^;]*/) ?? [];
  if (found) throw new Error(`${name}.js: expected a file that names no other, found ${found}`);
  for (const ending of ["js", "d.ts"]) rmSync(join(folder, `${worker}.${ending}`));
}

/**
 * Sources import each other with the extension .ts, and the modules from the folder of CMake.
 * TypeScript rewrites neither in declarations and in `new URL`. Declarations name the buffers of arrays as TypeScript 5.7
 * and later do, in a form that earlier versions understand.
 */
function fitReferences(file) {
  if (!existsSync(file)) return; // a worker
  let text = readFileSync(file, "utf8")
    .replaceAll(
      /"[^"\n]*\/(\w+_worker)\.ts", import\.meta\.url/g,
      '"../assets/$1.js", import.meta.url',
    )
    .replaceAll(/"\.\.\/\.\.\/build\/wasm\/web\/([^"\n]+\.wasm)"/g, '"../assets/$1"')
    .replaceAll("../../build/wasm/web/", "../wasm/")
    .replaceAll(/"(\.\.?\/[^"\n]+)\.ts"/g, '"$1.js"');
  if (file.endsWith(".d.ts")) {
    text = text
      .replaceAll(/\b(\w+Array)<ArrayBufferLike>/g, "$1")
      .replaceAll(/\b(\w+Array)<ArrayBuffer>/g, 'ReturnType<$1["slice"]>');
  }
  for (const [, reference = ""] of text.matchAll(/"(\.\.?\/[^"\n]+\.(?:js|wasm))"/g)) {
    if (!existsSync(join(dirname(file), reference))) {
      throw new Error(`${file}: expected ${reference} in the package, found none`);
    }
  }
  writeFileSync(file, text);
}

/** The declarations of layouts.js. In the sources, they are in a `declare module` with a pattern. */
function layoutsDeclarations() {
  const text = readFileSync(join(root, "web/core/generated.d.ts"), "utf8");
  const [, before, declarations] = text.match(/^(.*?)declare module "[^"]*" \{\n(.*)\}\n$/s) ?? [];
  if (!declarations) throw new Error("expected one declared module in web/core/generated.d.ts");
  return before + declarations.replaceAll(/^ {2}/gm, "");
}

function readJson(file) {
  return JSON.parse(readFileSync(file, "utf8"));
}
