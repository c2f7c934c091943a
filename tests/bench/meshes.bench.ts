// Compares meshes of every format, read by VTK, with VTK's Flying Edges of the same volume.
import { writeFileSync } from "node:fs";
import { join } from "node:path";
import type { Bench, Benchmark } from "./harness/benchmark.ts";
import { readNrrd } from "./harness/flying_edges.ts";

const cases = [
  { file: "fuel.nhdr", isovalue: 20.5 },
  { file: "engine.nhdr", isovalue: 60.5 },
  { file: "bonsai.nhdr", isovalue: 40.5 },
  { file: "aneurysm.nhdr", isovalue: 100.5 },
];
const formats = ["ply", "stl", "obj", "glb", "3mf"];

/** VTK's measures of a mesh, with vertices at the same position counted as one. */
interface Description {
  vertices: number;
  triangles: number;
  boundary: number;
  nonManifold: number;
  euler: number;
  area: number;
  volume: number;
}

async function runCase(bench: Bench, python: string, { file, isovalue }: (typeof cases)[number]) {
  const path = bench.volume(file);
  if (!path) return;
  const what = `${file.replace(/\..*/, "")} ${isovalue}`;
  bench.say(what);
  const script = join(bench.root, "tests/evidence/peers/check_meshes.py");
  const store = join(bench.folder, "store.isosplat");
  await bench.command(bench.isosplat, ["build", path, "-o", store, "--quiet", "--force"]);

  const extract = async (name: string, ...options: string[]) => {
    const out = join(bench.folder, name);
    const args = ["extract", store, "-i", String(isovalue), "--mesh", "--force", "-o", out];
    await bench.command(bench.isosplat, [...args, ...options]);
    return out;
  };
  const describe = async (...args: string[]) => {
    const { stdout } = await bench.command(python, [script, ...args]);
    return stdout
      .trim()
      .split("\n")
      .map((line) => JSON.parse(line) as Description);
  };

  const files: string[] = [];
  for (const format of formats) files.push(await extract(`mesh.${format}`, "--open"));
  const ours = await describe(...files);
  const [first] = ours;
  if (!first) return;

  const { voxels, type, data } = readNrrd(path);
  const raw = join(bench.folder, "volume.raw");
  writeFileSync(raw, data);
  const grid = [...voxels.map(String), type, "1", "1", "1"];
  const [peer] = await describe("--flying-edges", raw, ...grid, String(isovalue));
  if (!peer) return;

  const worst = (measure: (mesh: Description) => number) => Math.max(...ours.map(measure));
  bench.report(what, "triangles", "", first.triangles);
  bench.report(what, "Flying Edges: triangles", "", peer.triangles);
  bench.report(
    what,
    "formats with other numbers of triangles",
    "",
    ours.filter(({ triangles }) => triangles !== first.triangles).length,
    { atMost: 0 },
  );
  bench.report(what, "edges with more than two triangles", "", first.nonManifold, { atMost: 0 });
  bench.report(what, "Flying Edges: such edges", "", peer.nonManifold);
  bench.report(what, "edges at the end of the volume", "", first.boundary);
  bench.report(what, "Flying Edges: such edges at the end", "", peer.boundary);
  bench.report(what, "Euler number", "", first.euler);
  bench.report(what, "Flying Edges: Euler number", "", peer.euler);
  // GLB is in metres. Ambiguous cells may enclose a different volume, because Flying Edges decides
  // by the case alone.
  const share = ({ volume }: Description) => volume / peer.volume;
  const scaled = ours.map((mesh, i) =>
    formats[i] === "glb" ? { ...mesh, volume: mesh.volume * 1e9 } : mesh,
  );
  bench.report(
    what,
    "volume inside, greatest difference from Flying Edges",
    "%",
    100 * Math.max(...scaled.map((mesh) => Math.abs(1 - share(mesh)))),
    { atMost: 1 },
  );
  bench.report(
    what,
    "formats with edges of more than two triangles",
    "",
    worst(({ nonManifold }) => nonManifold),
    { atMost: 0 },
  );

  const [simple] = await describe(await extract("simple.ply", "--simplify", "0.1"));
  if (!simple) return;
  bench.report(what, "--simplify 0.1: triangles", "%", (100 * simple.triangles) / first.triangles);
  bench.report(what, "--simplify 0.1: edges with more than two triangles", "", simple.nonManifold);
  bench.report(what, "--simplify 0.1: area", "%", (100 * simple.area) / first.area);

  // The whole solid, and its parts on both sides of an oblique plane through the middle.
  const normal = [1, 2, -1.5];
  const offset = normal.reduce((sum, n, i) => sum + (n * ((voxels[i] ?? 1) - 1)) / 2, 0);
  const plane = (sign: number) => `--clip-plane=${[...normal, offset].map((n) => sign * n).join()}`;
  const solids = await describe(
    await extract("closed.stl"),
    await extract("one_side.stl", plane(1)),
    await extract("other_side.stl", plane(-1)),
  );
  const [closed, one, other] = solids;
  if (!closed || !one || !other) return;
  const most = (measure: (mesh: Description) => number) => Math.max(...solids.map(measure));
  bench.report(what, "closed: triangles", "%", (100 * closed.triangles) / first.triangles);
  bench.report(
    what,
    "closed, whole or cut: open edges",
    "",
    most(({ boundary }) => boundary),
    { atMost: 0 },
  );
  bench.report(
    what,
    "closed, whole or cut: edges with more than two triangles",
    "",
    most(({ nonManifold }) => nonManifold),
  );
  bench.report(
    what,
    "closed: difference of the parts' volume from the whole",
    "%",
    100 * Math.abs((one.volume + other.volume) / closed.volume - 1),
    { atMost: 0.1 },
  );
}

export default {
  title: "meshes of every format as VTK reads them, beside its Flying Edges",
  async run(bench) {
    const python = bench.pythonWithVtk();
    if (!python) return;
    for (const each of cases) await runCase(bench, python, each);
  },
} satisfies Benchmark;
