// The bytes of the page itself on the network, as a first visitor's browser fetches them. No figure
// depends on how busy the machine is.
import { join } from "node:path";
import type { Benchmark } from "./harness/benchmark.ts";
import { serve } from "./stream/serving.ts";
import { launch, Visitor } from "./stream/visit.ts";

export default {
  title: "bytes of the page itself, nothing cached",
  quick: true,
  async run(bench) {
    const url = await serve(bench, [join(bench.root, "build/demo/bucky.isosplat")]);
    const browser = await launch();
    try {
      const visitor = await Visitor.arrive(browser);
      await visitor.page.goto(`${url}?volume=bucky`);
      const { at } = await visitor.mark("isosplat:surface");
      await visitor.controls();
      const kilobytes = async (before?: number) => (await visitor.programBytes(before)) / 1000;
      const what = "the page, nothing cached";
      bench.report(what, "until the first surface", "KB", await kilobytes(at), { atMost: 230 });
      bench.report(what, "with all controls", "KB", await kilobytes());
    } finally {
      await browser.close();
    }
  },
} satisfies Benchmark;
