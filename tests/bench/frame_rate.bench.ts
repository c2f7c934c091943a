// Frame rates of all splat kinds, and of VTK's Flying Edges mesh (indexed triangles with normals) in
// the same renderer. The views are the 36 of the paper's experiment (section 6), and their middles
// six times as large. In each view, splats and mesh are measured by turns. Quads and the mesh are lit
// per vertex, the other kinds per pixel.
import type { Benchmark } from "./harness/benchmark.ts";
import { flyingEdgesMesh, renderProgram } from "./harness/render.ts";
import type { Reach } from "./harness/results.ts";

const cases: [string, number][] = [
  ["engine.nhdr", 60.5],
  ["bonsai.nhdr", 40.5],
  ["lobster.nhdr", 40.5],
  ["aneurysm.nhdr", 40.5],
];
const kinds = ["quad", "ellipse", "exact", "smooth"] as const;
const reaches: Partial<Record<(typeof kinds)[number], Reach>> = {
  quad: { atLeast: 2 },
  ellipse: { atLeast: 1 },
  exact: { atLeast: 0.7 },
  smooth: { atLeast: 0.5 },
};

export default {
  title: "frame rates, 1024², 36 views, splats against triangles",
  async run(bench) {
    for (const [name, isovalue] of cases) {
      const volume = bench.volume(name);
      if (!volume) continue;
      const mesh = await flyingEdgesMesh(bench, volume, isovalue);
      if (!mesh) return;
      const program = renderProgram("isosplat_frame_rate");
      for (const closeUp of [1, 6]) {
        const { stdout } = await bench.command(program, [
          ...[volume, String(isovalue), mesh],
          ...["--close-up", String(closeUp)],
        ]);
        const row = JSON.parse(stdout) as Record<string, number | string>;
        const measure = (name: string) => (closeUp === 1 ? name : `close-up: ${name}`);
        const what = `${name.replace(/\..*/, "")} ${isovalue}`;
        const triangles = Number(row.mesh_ms);
        bench.report(`${what}, mesh`, measure("time"), "ms", triangles);
        for (const kind of kinds) {
          const time = Number(row[`${kind}_ms`]);
          const reach = closeUp === 1 ? reaches[kind] : undefined;
          const frames = measure("frames per mesh frame");
          bench.report(`${what}, ${kind}`, measure("time"), "ms", time);
          bench.report(`${what}, ${kind}`, frames, "×", triangles / time, reach);
        }
      }
    }
  },
} satisfies Benchmark;
