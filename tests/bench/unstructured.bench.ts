// Building scenes of unstructured meshes within --memory 2G: the time and the peak memory, beside
// those of VTK, which reads and contours the same file.
import { existsSync, statSync } from "node:fs";
import { join } from "node:path";
import type { Bench, Benchmark } from "./harness/benchmark.ts";

const isovalue = 0.3;
const limit = 2048; // MiB

/** The tetrahedra of each mesh. 10 million need 0.5 GB of disk for the mesh. */
const counts = (process.env.ISOSPLAT_BENCH_UNSTRUCTURED ?? "200000,2000000").split(",").map(Number);

interface Contour {
  read: number;
  contour: number;
  triangles: number;
}

async function runCase(bench: Bench, python: string, count: number) {
  const folder = join(bench.root, "tests/bench/unstructured");
  const mesh = join(bench.folder, `tetrahedra_${count}.vtu`);
  const { stdout } = await bench.command(python, [
    join(folder, "write_tetrahedra.py"),
    String(count),
    mesh,
  ]);
  const tetrahedra = Number(stdout);
  const what = `${tetrahedra.toLocaleString("en")} tetrahedra`;
  bench.say(what);
  const output = join(bench.folder, "mesh.isobundle");
  const peaks = { ours: 0, vtk: 0 };
  let contour: Contour | undefined;
  const build = ["build", mesh, "-o", output, "--force", "--no-thumbnail", "--memory", "2G"];
  const { ours, vtk } = await bench.interleave(
    {
      ours: async () => {
        const { seconds, peakBytes } = await bench.command(bench.isosplat, build);
        peaks.ours = Math.max(peaks.ours, peakBytes);
        return seconds;
      },
      vtk: async () => {
        const script = join(folder, "contour.py");
        const ended = await bench.command(python, [script, mesh, String(isovalue)]);
        peaks.vtk = Math.max(peaks.vtk, ended.peakBytes);
        contour = JSON.parse(ended.stdout) as Contour;
        return contour.read + contour.contour;
      },
    },
    Math.min(bench.runs, count > 1e6 ? 1 : 3),
  );
  if (!contour || !existsSync(output)) return;
  bench.report(what, "file", "MB", statSync(mesh).size / 1e6);
  bench.report(what, "store of all levels", "MB", statSync(output).size / 1e6);
  bench.report(what, "build", "s", ours);
  bench.report(what, "VTK reads and contours", "s", vtk);
  const ratios = ours.map((seconds, i) => seconds / (vtk[i] ?? Number.NaN));
  bench.report(what, "build / VTK", "", ratios, { atMost: 3 });
  bench.report(what, "peak memory", "MiB", peaks.ours / 2 ** 20, { atMost: limit });
  bench.report(what, "peak memory of VTK", "MiB", peaks.vtk / 2 ** 20);
}

export default {
  title: "building scenes of unstructured meshes, beside VTK's reader and contour filter",
  async run(bench) {
    const python = bench.pythonWithVtk();
    if (!python) return;
    for (const count of counts) await runCase(bench, python, count);
  },
} satisfies Benchmark;
