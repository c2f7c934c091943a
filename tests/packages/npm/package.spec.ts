// The npm package in Node, and its types: installed from the tarball into an empty folder.
import { execFile, execFileSync } from "node:child_process";
import { existsSync, readdirSync, readFileSync } from "node:fs";
import { join } from "node:path";
import { promisify } from "node:util";
import { afterAll, beforeAll, expect, test } from "vitest";
import { hasNginx, nginx } from "../../support/nginx.ts";
import { countActive, offset } from "../../web/fixture.ts";
import { table } from "../bundlers/fixtures.ts";
import { type Consumer, consumer, examples, root, tarball, version } from "./consumer.ts";

let project: Consumer;

beforeAll(() => {
  project = consumer();
}, 120_000);
afterAll(() => project.remove());

/** What a program of the project prints. */
async function run(file: string): Promise<string> {
  const options = { cwd: project.folder, encoding: "utf8" } as const;
  const { stdout, stderr } = await promisify(execFile)(process.execPath, [file], options);
  expect(stderr.replaceAll(/^ *\d+ %\r?|\r/gm, "").trim(), "warnings").toBe("");
  return stdout.trim();
}

const points = (): number => countActive(60.5 - offset);

test("the tarball holds what its manifest promises, and no sources", () => {
  const files = execFileSync("tar", ["-tf", tarball], { encoding: "utf8" }).trim().split("\n");
  for (const file of ["LICENSE", "README.md", "THIRD_PARTY_LICENSES.md"]) {
    expect(files).toContain(`package/${file}`);
  }
  expect(files.filter((file) => /(?<!\.d)\.ts$/.test(file))).toEqual([]);
  const installed = join(project.folder, "node_modules/isosplat");
  const manifest = JSON.parse(readFileSync(join(installed, "package.json"), "utf8"));
  expect(manifest.version).toBe(version);
  expect(manifest.license).toBe("Apache-2.0");
  expect(manifest.dependencies).toBeUndefined();
  const targets = Object.values<string | object>(manifest.exports).flatMap((target) =>
    typeof target === "string" ? [target] : Object.values<string>(target as never),
  );
  for (const file of [...targets, ...manifest.sideEffects, manifest.main, manifest.types]) {
    if (!file.includes("*")) expect(existsSync(join(installed, file)), file).toBe(true);
  }
  // Tools that do not read `exports` find these by their paths.
  for (const name of Object.keys(manifest.exports).filter((path) => /^\.\/\w+$/.test(path))) {
    const places = [`${name}.js`, `${name}/index.js`].map((file) => join(installed, file));
    expect(places.some(existsSync), name).toBe(true);
  }
});

test("workers and WebAssembly are files that name no other, so that they can be copied", () => {
  const assets = join(project.folder, "node_modules/isosplat/assets");
  expect(readdirSync(assets).sort()).toEqual([
    "decode_worker.js",
    "isosplat-core.wasm",
    "isosplat-mesh.wasm",
    "isosplat-renderer.wasm",
    "mesh_worker.js",
  ]);
  for (const file of readdirSync(assets).filter((name) => name.endsWith(".js"))) {
    expect(readFileSync(join(assets, file), "utf8")).not.toMatch(/\bimport\b|\bexport\b|new URL/);
  }
});

test("bundlers find the workers: by the global constructor and a literal address", () => {
  const installed = join(project.folder, "node_modules/isosplat");
  for (const [file, worker] of [
    ["stream/worker_pool.js", "decode_worker"],
    ["mesh/mesher.js", "mesh_worker"],
  ]) {
    const text = readFileSync(join(installed, file ?? ""), "utf8");
    expect(text).toContain(
      `new Worker(new URL("../assets/${worker}.js", import.meta.url), { type: "module" })`,
    );
    expect(text).not.toMatch(/(const|let|var|class|import .*) Worker\b/);
  }
});

test("without a DOM, importing any entry point does nothing", async () => {
  const { exports } = JSON.parse(
    readFileSync(join(project.folder, "node_modules/isosplat/package.json"), "utf8"),
  );
  const names = Object.keys(exports)
    .filter((path) => !/[*]|json/.test(path))
    .map((path) => `isosplat${path.slice(1)}`);
  expect(names.length).toBeGreaterThan(9);
  const imports = names.map((name) => `await import("${name}");`).join("\n");
  const print = "console.log(typeof customElements, typeof document);";
  project.write("without_dom.mjs", `${imports}\n${print}\n`);
  expect(await run("without_dom.mjs")).toBe("undefined undefined");
});

test("the README has the table of the bundlers that are tried", () => {
  const readme = readFileSync(join(project.folder, "node_modules/isosplat/README.md"), "utf8");
  const [, found] = readme.match(/<!-- tools -->\n([\s\S]*?)\n<!-- tools end -->/) ?? [];
  expect(found).toBe(table()); // tests/packages/bundlers/check --table
});

test("the README has the examples", () => {
  expect([...examples(project.folder).keys()]).toEqual(
    expect.arrayContaining([
      "points.mjs",
      "remote.mjs",
      "triangles.mjs",
      "plain.html",
      "element.html",
      "main.js",
      "own.js",
    ]),
  );
});

test("the README names members that the declarations have", () => {
  const installed = join(project.folder, "node_modules/isosplat");
  const declarations: Record<string, string> = {
    core: "core/core.d.ts",
    store: "core/core.d.ts",
    session: "stream/session.d.ts",
    viewer: "viewer/viewer.d.ts",
  };
  const readme = readFileSync(join(installed, "README.md"), "utf8");
  const members = [...readme.matchAll(/`(core|store|session|viewer)\.(\w+)/g)];
  expect(members.length).toBeGreaterThan(15);
  for (const [, object = "", member = ""] of members) {
    const declared = readFileSync(join(installed, declarations[object] ?? ""), "utf8");
    const inherited = member === "on"; // Emitter
    if (!inherited) expect(declared).toMatch(new RegExp(`^ {4}(readonly |get )?${member}\\b`, "m"));
  }
});

test("example 1: a local store in Node", async () => {
  expect(await run("points.mjs")).toBe(`150 × 131 × 70 voxels, ${points()} points`);
});

test.skipIf(!hasNginx)("example 2: a remote store in Node", async () => {
  const server = await nginx({ folders: [project.folder] });
  try {
    const text = examples(project.folder).get("remote.mjs") ?? "";
    expect(text).toContain("https://example.org/");
    project.write("remote_here.mjs", text.replace("https://example.org/", server.url));
    const [, count, bytes] = /^(\d+) points, (\d+) bytes/.exec(await run("remote_here.mjs")) ?? [];
    expect(Number(count)).toBe(points());
    const whole = readFileSync(join(project.folder, "head.isosplat")).length;
    expect(Number(bytes)).toBeLessThan(whole);
  } finally {
    await server.stop();
  }
});

test.skipIf(!hasNginx)("example 2: its isosurface as triangles", async () => {
  const server = await nginx({ folders: [project.folder] });
  try {
    const text = examples(project.folder).get("triangles.mjs") ?? "";
    project.write("triangles_here.mjs", text.replace("https://example.org/", server.url));
    const [, triangles] = /(\d+) triangles$/.exec(await run("triangles_here.mjs")) ?? [];
    expect(Number(triangles)).toBeGreaterThan(10_000);
    const file = readFileSync(join(project.folder, "head.stl"));
    expect(file.length).toBe(84 + 50 * Number(triangles));
  } finally {
    await server.stop();
  }
});

// Everything that an entry point exports is compiled with it: the libraries' types are checked.
const use = `
import { type Chunk, type Core, CoreError, loadCore, type Points, type Store } from "isosplat/core";
import { FileSource, type Progress, ServerSource, StreamSession, faults } from "isosplat/stream";
import { type SavedSurface, saveSurface, SurfaceReader } from "isosplat/mesh";
import { type Camera, Viewer, RendererError } from "isosplat/viewer";
import "isosplat/element";

export async function run(canvas: HTMLCanvasElement, bytes: Uint8Array): Promise<number> {
  const core: Core = await loadCore();
  const store: Store = core.openStore(bytes);
  const [chunk]: Chunk[] = store.chunksFor(0, 60.5);
  if (!chunk) throw new CoreError("not_found", "no chunk");
  const points: Points = store.project(chunk, bytes, 60.5, { exact: true });
  const viewer = new Viewer(canvas, { controls: false });
  viewer.on("progress", (progress: Progress) => console.log(progress.state, Object.keys(faults).length));
  viewer.on("error", (error) => console.log(error instanceof RendererError, error.kind));
  await viewer.open(new ServerSource({ volume: "header" }), { signal: AbortSignal.timeout(1) });
  const camera: Camera | null = viewer.camera;
  if (viewer.storeAccess) {
    const saved: SavedSurface = await saveSurface(new SurfaceReader(viewer.storeAccess), 60.5);
    console.log(saved.file.size);
  }
  const session = await StreamSession.open(new FileSource("head.isosplat"), core, {
    events: {
      samples: () => true,
      drop() {},
      visible() {},
      progress() {},
      error() {},
      replaced() {},
    },
  });
  session.close();
  const view = document.createElement("isosplat-viewer");
  view.addEventListener("isovaluechange", ({ detail }) => console.log(detail.length, view.info?.range));
  view.isovalues = [60.5];
  // @ts-expect-error: isovalues are numbers
  view.isovalues = "60.5";
  // @ts-expect-error: a volume is opened from a source
  await viewer.open("head.isosplat");
  // @ts-expect-error: there is no such event
  viewer.on("nothing", () => {});
  return points.count + (camera?.azimuth ?? 0);
}
`;

/** The messages of TypeScript for a source in a strict project. */
async function complaints(source: string, options: object): Promise<string> {
  project.write("use.ts", source);
  const compilerOptions = {
    ...options,
    target: "es2022",
    strict: true,
    exactOptionalPropertyTypes: true,
    skipLibCheck: false,
    noEmit: true,
  };
  project.write("tsconfig.json", JSON.stringify({ compilerOptions, files: ["use.ts"] }));
  const tsc = join(root, "node_modules/.bin/tsc");
  return promisify(execFile)(tsc, ["-p", project.folder]).then(
    ({ stdout }) => stdout,
    (error: { stdout: string }) => error.stdout,
  );
}

test.each([
  { module: "node16", moduleResolution: "node16" },
  { module: "esnext", moduleResolution: "bundler" },
])("the types hold in a project for browsers: $moduleResolution", async (resolution) => {
  const lib = ["es2022", "dom", "dom.iterable"];
  expect(await complaints(use, { ...resolution, lib, types: [] })).toBe("");
});

test("the types of core and stream hold in a project for Node, without the browser's", async () => {
  const source = `
    import { loadCore } from "isosplat/core";
    import { FileSource } from "isosplat/stream";
    const header: Uint8Array = await new FileSource("u").header(AbortSignal.timeout(1));
    export const { info } = (await loadCore()).openStore(header);
  `;
  const options = {
    module: "node16",
    lib: ["es2022"],
    types: ["node"],
    typeRoots: [join(root, "node_modules/@types")],
  };
  expect(await complaints(source, options)).toBe("");
});
