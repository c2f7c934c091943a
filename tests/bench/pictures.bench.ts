// Draws the pictures of docs/PICTURES.md again, with the present renderer: figures of the paper, and
// sheets that compare views with other programs. Measures nothing. ISOSPLAT_BENCH_PICTURES=engine draws
// those whose names match.
import type { Benchmark } from "./harness/benchmark.ts";
import { drawFigures } from "./pictures/figures.ts";
import { drawSheets } from "./pictures/sheets.ts";

const wanted = new RegExp(process.env.ISOSPLAT_BENCH_PICTURES ?? "");

export default {
  title: "pictures of the documents",
  async run(bench) {
    await drawFigures(bench, wanted);
    await drawSheets(bench, wanted);
  },
} satisfies Benchmark;
