// Measures the accuracy and smoothness of normals. The accuracy is the angle to a reference, for cells of
// 8 px: the gradient by central differences at the voxels, interpolated trilinearly. The smoothness is the
// jump (95th percentile) across faces between cells, between blocks, and between levels. It is measured for
// cells of 32 px, so that a pixel is a small step. isosplat_normals describes the method. The normals of
// extracted points are compared with the same reference, and their time is measured.
import type { Benchmark } from "./harness/benchmark.ts";
import { renderProgram } from "./harness/render.ts";
import { buildStore } from "./stream/serving.ts";

const cases: [string, number][] = [
  ["engine.nhdr", 60.5],
  ["bonsai.nhdr", 40.5],
  ["aneurysm.nhdr", 100.5],
  ["mni152.nii.gz", 700.5],
  ["bunny_ct_i16.nrrd", 1000.5],
];

interface Points {
  points: number;
  median: number;
  p95: number;
  /** Seconds of each run. */
  seconds: number[];
}

interface Figures {
  median: number;
  p95: number;
  cells: number;
  blocks: number;
  levels: number;
}

export default {
  title: "normals in close-ups, and of points",
  async run(bench) {
    for (const [file, isovalue] of cases) {
      const volume = bench.volume(file);
      if (!volume) continue;
      const name = file.replace(/\..*/, "");
      const store = await buildStore(bench, volume, name);
      const program = renderProgram("isosplat_normals");
      const measure = async (px: string) => {
        const { stdout } = await bench.command(program, [
          ...[store, volume, String(isovalue), "--px", px],
        ]);
        return JSON.parse(stdout) as Record<"smooth" | "exact", Figures>;
      };
      const angles = await measure("8");
      const jumps = await measure("32");
      for (const shading of ["exact", "smooth"] as const) {
        const what = `${name} ${isovalue}, ${shading}`;
        const most = (limit: number) => (shading === "smooth" ? { atMost: limit } : undefined);
        const { median, p95 } = angles[shading];
        const { cells, blocks, levels } = jumps[shading];
        bench.report(what, "angle, median", "°", median, most(2));
        bench.report(what, "angle, 95 %", "°", p95, most(8));
        bench.report(what, "jump between cells, 95 %", "°", cells, most(1));
        bench.report(what, "jump between blocks, 95 %", "°", blocks, most(1));
        bench.report(what, "jump between levels, 95 %", "°", levels, most(1));
      }
      const { stdout } = await bench.command(renderProgram("isosplat_point_normals"), [
        ...[store, volume, String(isovalue), String(bench.runs)],
      ]);
      const points = JSON.parse(stdout) as Record<"smooth" | "exact", Points>;
      for (const shading of ["exact", "smooth"] as const) {
        const what = `${name} ${isovalue}, points, ${shading}`;
        const { median, p95, seconds } = points[shading];
        const most = (limit: number) => (shading === "smooth" ? { atMost: limit } : undefined);
        bench.report(what, "angle, median", "°", median, most(2));
        bench.report(what, "angle, 95 %", "°", p95, most(8));
        const ms = seconds.map((s) => 1000 * s);
        bench.report(what, "extraction, 2 threads", "ms", ms);
      }
    }
  },
} satisfies Benchmark;
