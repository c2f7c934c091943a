// Frame rates of all splat kinds, and of VTK's Flying Edges mesh (indexed triangles with normals) in
// the same renderer, over the 36 views of the paper's experiment (section 6), interleaved. Quads and the
// mesh are lit per vertex, the other kinds per pixel.
import type { Benchmark } from "./harness/benchmark.ts";
import { flyingEdgesMesh, renderProgram } from "./harness/render.ts";

const cases: [string, number][] = [
  ["engine.nhdr", 60.5],
  ["bonsai.nhdr", 40.5],
  ["lobster.nhdr", 40.5],
  ["aneurysm.nhdr", 40.5],
];
const kinds = ["quad", "ellipse", "exact", "smooth"] as const;

export default {
  title: "frame rates, 1024², 36 views, splats against triangles",
  async run(bench) {
    for (const [name, isovalue] of cases) {
      const volume = bench.volume(name);
      if (!volume) continue;
      const mesh = await flyingEdgesMesh(bench, volume, isovalue);
      if (!mesh) return;
      const program = renderProgram("isosplat_frame_rate");
      const { stdout } = await bench.command(program, [volume, String(isovalue), mesh]);
      const row = JSON.parse(stdout) as Record<string, number | string>;
      const what = `${name.replace(/\..*/, "")} ${isovalue}`;
      const triangles = Number(row.mesh_ms);
      bench.report(`${what}, mesh`, "time", "ms", triangles);
      for (const kind of kinds) {
        const time = Number(row[`${kind}_ms`]);
        bench.report(`${what}, ${kind}`, "time", "ms", time);
        const reach = { quad: { atLeast: 2 }, smooth: { atLeast: 0.5 } }[kind as string];
        bench.report(`${what}, ${kind}`, "frames per mesh frame", "×", triangles / time, reach);
      }
    }
  },
} satisfies Benchmark;
