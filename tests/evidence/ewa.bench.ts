// Compares alias and blur of the renderer's splats with a textbook EWA resampling filter (Zwicker
// et al. 2001), on a plane with a checker pattern and on engine. Draws the pictures of
// docs/bench/ewa again.
import { existsSync, mkdirSync } from "node:fs";
import { join } from "node:path";
import type { Benchmark } from "../bench/harness/benchmark.ts";
import { buildStore } from "../bench/stream/serving.ts";

const isovalue = 60.5;

interface Row {
  scene: string;
  way: string;
  measure: string;
  unit: string;
  value: number;
}

export default {
  title: "alias and blur of splats, and of an EWA resampling filter",
  async run(bench) {
    const program = join(bench.root, "build/release/tests/evidence/ewa/isosplat_ewa_study");
    if (!existsSync(program)) throw new Error(`${program} is not built. Run: npm run build`);
    const volume = bench.volume("engine.nhdr");
    if (!volume) return;
    const store = await buildStore(bench, volume, "engine.nhdr");
    const pictures = join(bench.root, "docs/bench/ewa");
    mkdirSync(pictures, { recursive: true });
    const { stdout } = await bench.command(program, [volume, store, String(isovalue), pictures]);
    for (const line of stdout.trim().split("\n")) {
      const { scene, way, measure, unit, value } = JSON.parse(line) as Row;
      const what = scene === "checker" ? scene : `engine ${isovalue} ${scene}`;
      bench.report(`${what}, ${way}`, measure, unit, value);
    }
  },
} satisfies Benchmark;
