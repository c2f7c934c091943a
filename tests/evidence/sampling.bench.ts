// Compares cost and quality of the paper's projections (section 3: one Newton step, exact) and
// samplings (section 4: one sample for a cell, octants of all cells, octants of cells with wide
// intervals).
import { existsSync } from "node:fs";
import { join } from "node:path";
import type { Benchmark } from "../bench/harness/benchmark.ts";

const cases: [string, number][] = [
  ["fuel.nhdr", 20.5],
  ["engine.nhdr", 60.5],
  ["bonsai.nhdr", 40.5],
  ["aneurysm.nhdr", 100.5],
];

interface Row {
  sampling: string;
  projection: string;
  samples: number;
  seconds: number;
  dropped: number;
  outside: number;
  error_mean: number;
  error_95: number;
  error_max: number;
  gap_mean: number;
  gap_95: number;
  gap_max: number;
  hole: number;
}

export default {
  title: "samplings and projections of the paper: errors, gaps, dropped samples, time",
  async run(bench) {
    const program = join(
      bench.root,
      "build/release/tests/evidence/sampling/isosplat_sampling_study",
    );
    if (!existsSync(program)) throw new Error(`${program} is not built. Run: npm run build`);
    for (const [file, isovalue] of cases) {
      const volume = bench.volume(file);
      if (!volume) continue;
      bench.say(file);
      const { stdout } = await bench.command(program, [volume, String(isovalue)]);
      const rows = stdout
        .trim()
        .split("\n")
        .map((line) => JSON.parse(line) as Row);
      const shipped = rows.find(
        ({ sampling, projection }) => sampling === "centre" && projection === "newton clamped",
      );
      for (const row of rows) {
        const what = `${file.replace(/\..*/, "")} ${isovalue}, ${row.sampling}, ${row.projection}`;
        bench.report(what, "samples", "", row.samples);
        bench.report(
          what,
          "time, of centre samples with one step",
          "×",
          row.seconds / (shipped?.seconds ?? 1),
        );
        bench.report(what, "dropped samples", "%", 100 * row.dropped);
        bench.report(what, "points outside of their cell", "%", 100 * row.outside);
        bench.report(what, "from points to the surface, mean", "cells", row.error_mean);
        bench.report(what, "from points to the surface, 95 %", "cells", row.error_95);
        bench.report(what, "from points to the surface, largest", "cells", row.error_max);
        bench.report(what, "from the surface to points, mean", "cells", row.gap_mean);
        bench.report(what, "from the surface to points, 95 %", "cells", row.gap_95);
        bench.report(what, "from the surface to points, largest", "cells", row.gap_max);
        bench.report(
          what,
          "surface beyond half a cell's diagonal from all points",
          "%",
          100 * row.hole,
        );
      }
    }
  },
} satisfies Benchmark;
