// Errors of pictures, compared with a ray caster of the trilinear field in double precision. Holes:
// pixels at least 2 px from the reference's outlines and depth edges that show the background or
// are more than 2 cells behind the reference. Depth and normal errors: means over the same pixels.
// A cell's length is the smallest spacing. "mesh" is VTK's Flying Edges mesh with its normals,
// drawn by the same renderer. Then follow coarse levels, as they are drawn while something moves:
// the area that they cover beyond that of the reference, which is at level 0.
import type { Benchmark } from "./harness/benchmark.ts";
import { flyingEdgesMesh, renderProgram } from "./harness/render.ts";
import type { Reach } from "./harness/results.ts";
import { buildStore } from "./stream/serving.ts";

const cases: [string, number][] = [
  ["fuel.nhdr", 20.5],
  ["engine.nhdr", 60.5],
  ["engine.nhdr", 180.5],
  ["bonsai.nhdr", 40.5],
  ["aneurysm.nhdr", 40.5],
  ["lobster.nhdr", 40.5],
  ["statueLeg.nhdr", 60.5],
  ["bunny_ct_i16.nrrd", 1000.5],
];

const coarseCases: [string, number][] = [
  ["engine.nhdr", 60.5],
  ["engine.nhdr", 160.5],
  ["bonsai.nhdr", 40.5],
  ["aneurysm.nhdr", 40.5],
  ["bunny_ct_i16.nrrd", 1000.5],
];

interface Row {
  view: string;
  kind: string;
  /**
   * Pixels of the reference, those of them that are not covered, and covered pixels outside of the
   * reference.
   */
  reference: number;
  missed: number;
  excess: number;
  holes: number;
  silhouette: number;
  depth: number;
  normal: number;
}

const silhouette: Record<string, number> = {
  quad: 0.03,
  ellipse: 0.015,
  exact: 0.002,
};
const depth: Record<string, number> = { quad: 0.35, ellipse: 0.2, exact: 0.01 };

export default {
  title: "fidelity of pictures, 1024², three views",
  async run(bench) {
    for (const [name, isovalue] of cases) {
      const volume = bench.volume(name);
      if (!volume) continue;
      const mesh = await flyingEdgesMesh(bench, volume, isovalue);
      const options = mesh ? ["--mesh", mesh] : [];
      const program = renderProgram("isosplat_fidelity");
      const { stdout } = await bench.command(program, [volume, String(isovalue), ...options]);
      const rows = stdout
        .trim()
        .split("\n")
        .map((line) => JSON.parse(line) as Row);
      for (const row of rows) {
        const what = `${name.replace(/\..*/, "")} ${isovalue}, ${row.view}, ${row.kind}`;
        const most = (limit: number | undefined): Reach | undefined =>
          limit === undefined ? undefined : { atMost: limit };
        const ofMesh = rows.find((r) => r.view === row.view && r.kind === "mesh")?.normal;
        const normal = {
          ellipse: ofMesh && 1.2 * ofMesh,
          exact: 1,
        }[row.kind];
        const ours = row.kind !== "mesh";
        bench.report(what, "holes", "px", row.holes, ours ? { atMost: 0 } : undefined);
        bench.report(what, "outline", "of area", row.silhouette, most(silhouette[row.kind]));
        bench.report(what, "depth error", "cells", row.depth, most(depth[row.kind]));
        bench.report(what, "normal error", "°", row.normal, most(normal));
      }
    }
    for (const [name, isovalue] of coarseCases) {
      const volume = bench.volume(name);
      if (!volume) continue;
      const store = await buildStore(bench, volume, `${name}-${isovalue}`);
      for (const level of [1, 2, 3]) {
        for (const view of ["front", "back"]) {
          const { stdout } = await bench.command(renderProgram("isosplat_fidelity"), [
            ...[volume, String(isovalue), "--store", store, "--level", String(level)],
            ...["--view", view, "--size", "512"],
          ]);
          for (const line of stdout.trim().split("\n")) {
            const row = JSON.parse(line) as Row;
            const what = `${name.replace(/\..*/, "")} ${isovalue}, level ${level}, ${view}, ${row.kind}`;
            const { reference, missed, excess } = row;
            const area = Math.abs(excess - missed) / reference;
            bench.report(what, "area error", "of area", area, { atMost: 0.15 });
            bench.report(what, "outline", "of area", (excess + missed) / reference);
          }
        }
      }
    }
  },
} satisfies Benchmark;
