/**
 * Writes docs/DEPENDENCIES.md: every package that Isosplat is built, tested or measured with.
 *
 *     npm run dependencies            writes the file
 *     npm run dependencies -- --print prints it instead
 *
 * Debian packages come from .ci/install-packages. Versions and licences of npm packages come from
 * the lock files; `uses` says what each is for.
 */
import { execFileSync } from "node:child_process";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { fileURLToPath } from "node:url";

const root = fileURLToPath(new URL("..", import.meta.url));

const uses = {
  "@awesome.me/webawesome": "the page's controls",
  "@biomejs/biome": "formats and lints TypeScript",
  "@custom-elements-manifest/analyzer": "writes the reference of the element",
  "@gltf-transform/core": "reads glTF, to compare with in benchmarks",
  "@gltf-transform/extensions": "compressed glTF, to compare with in benchmarks",
  "@gltf-transform/functions": "compresses glTF, to compare with in benchmarks",
  "@kitware/vtk.js": "a viewer to compare with in benchmarks",
  "@niivue/niivue": "a viewer to compare with in benchmarks",
  "@playwright/test": "runs the tests in Chromium",
  "@sveltejs/vite-plugin-svelte": "compiles Svelte, to test the element in it",
  "@types/node": "types of Node",
  "@types/react": "types of React, for the element's types",
  "@types/react-dom": "types of React, in tests",
  "@types/s3rver": "types of s3rver",
  "@vitejs/plugin-vue": "compiles Vue, to test the element in it",
  "@zip.js/zip.js": "reads ZIP archives that are dropped on the page",
  ajv: "compares the server's answers with its OpenAPI document, and SBOMs with their schema",
  "axe-core": "finds faults of accessibility, in tests",
  "client-zip": "writes the ZIP archive of a static site that the page saves",
  fzstd: "decompresses Zstandard in the browser",
  gifenc: "animated GIFs that the page saves",
  lit: "templates of the page and the element",
  lucide: "icons",
  meshoptimizer: "compresses meshes, to compare with in benchmarks",
  "mp4-muxer": "MP4 videos that the page saves",
  numcodecs: "compressed chunks of Zarr, in tests",
  pako: "decompresses gzip in the browser",
  "puppeteer-core": "drives Firefox in tests",
  react: "tests the element in React",
  "react-dom": "tests the element in React",
  s3rver: "an S3 service, to test buckets",
  svelte: "tests the element in Svelte",
  three: "draws meshes, to compare with in benchmarks",
  tsx: "runs TypeScript: the benchmarks",
  typescript: "checks types, compiles the npm package",
  "unbzip2-stream": "decompresses bzip2 in the browser",
  vega: "plots of the benchmarks' results",
  "vega-lite": "plots of the benchmarks' results",
  vite: "builds the page",
  vitest: "runs the tests in Node and Firefox",
  vue: "tests the element in Vue",
  "webm-muxer": "WebM videos that the page saves",
  "xxhash-wasm": "checksums of Zstandard in the browser",
  "xz-decompress": "decompresses xz in the browser",
  zarrita: "reads OME-Zarr and Zarr at addresses",
};

const purposes = {
  start: "To build and run",
  package: "To make packages",
  test: "To test",
  release: "To check a release",
  bench: "To compare with in benchmarks",
};

const named = new Set();
const row = (...cells) => `| ${cells.join(" | ")} |`;

function debian() {
  const list = execFileSync("bash", [join(root, ".ci/install-packages"), "--table"], {
    encoding: "utf8",
  });
  const entries = list.trimEnd().split("\n");
  return Object.entries(purposes).flatMap(([purpose, title]) => [
    `### ${title}`,
    "",
    row("package", "version", "licence", "what for"),
    row("---", "---", "---", "---"),
    ...entries
      .map((entry) => entry.split("|"))
      .filter(([use]) => use === purpose)
      .map(([, names, version, licence, reason]) =>
        row(names.split(",")[0].replace(/>=.*/, ""), version, licence, reason),
      ),
    "",
  ]);
}

/** The table of the packages that FOLDER/package.json names. */
function npm(folder) {
  const read = (file) => JSON.parse(readFileSync(join(root, folder, file), "utf8"));
  const { dependencies = {}, devDependencies = {} } = read("package.json");
  const { packages } = read("package-lock.json");
  return [
    row("package", "version", "licence", "what for"),
    row("---", "---", "---", "---"),
    ...Object.keys({ ...dependencies, ...devDependencies })
      .sort()
      .map((name) => {
        if (!uses[name]) {
          throw new Error(
            `.ci/dependencies.mjs: expected what ${name} is for in "uses", found none`,
          );
        }
        named.add(name);
        const { version, license } = packages[`node_modules/${name}`];
        return row(name, version, license.replace(/^\((.*)\)$/, "$1"), uses[name]);
      }),
    "",
  ];
}

const text = [
  "# Dependencies",
  "",
  "`npm run dependencies` writes this document; do not edit it.",
  "",
  "Native libraries are Debian packages, and JavaScript libraries are npm packages with exact versions in `package-lock.json`. A WebAssembly module holds the core, tl::expected and xxHash. The modules that read volume files, build stores or write meshes also hold nlohmann/json; the module that reads volume files also holds {fmt}. The npm package `isosplat` has no dependencies. Each release has a list of all that its packages contain or depend on, with exact versions ([list of components](../RELEASE.md#list-of-components)).",
  "",
  "## Debian packages",
  "",
  "`.ci/install-packages` installs them. Versions are those of Debian 12.",
  "",
  ...debian(),
  "## npm packages",
  "",
  ...npm("."),
  "### To compare with in benchmarks",
  "",
  "`tests/evidence/peers` installs them.",
  "",
  ...npm("tests/evidence/peers"),
]
  .join("\n")
  .replace(/\n+$/, "\n");

const unused = Object.keys(uses).filter((name) => !named.has(name));
if (unused.length > 0) {
  throw new Error(
    `.ci/dependencies.mjs: expected a package.json that names ${unused}, which "uses" names, found none: remove it from "uses"`,
  );
}
if (process.argv.includes("--print")) process.stdout.write(text);
else writeFileSync(join(root, "docs/DEPENDENCIES.md"), text);
