// Draws the pictures of docs/PICTURES.md again, with the present renderer: figures of the paper, sheets
// that compare views with other programs, and the page. Measures nothing. ISOSPLAT_BENCH_PICTURES=engine
// draws those whose names match.
import type { Benchmark } from "./harness/benchmark.ts";
import { drawFigures } from "./pictures/figures.ts";
import { drawPageStates } from "./pictures/page_states.ts";
import { drawSheets } from "./pictures/sheets.ts";

const wanted = new RegExp(process.env.ISOSPLAT_BENCH_PICTURES ?? "");

export default {
  title: "pictures of the documents",
  async run(bench) {
    await drawFigures(bench, wanted);
    await drawSheets(bench, wanted);
    await drawPageStates(bench, wanted);
  },
} satisfies Benchmark;
