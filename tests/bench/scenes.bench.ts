// Scenes with many layers in the page: the time until each layer has a surface, and until all are
// complete.
import { writeFileSync } from "node:fs";
import { join } from "node:path";
import type { Browser } from "@playwright/test";
import { type LabelVolume, manyLabels, organs } from "../support/labels.ts";
import type { Bench, Benchmark } from "./harness/benchmark.ts";
import { serve } from "./stream/serving.ts";
import { launch, links, Visitor } from "./stream/visit.ts";

interface Case {
  name: string;
  what: string;
  volume: LabelVolume;
  /** Longest time (s) until each label has a surface. */
  within: number;
}

async function build(bench: Bench, { name, volume }: Case): Promise<string> {
  const path = join(bench.folder, `${name}.nrrd`);
  const bundle = join(bench.folder, `${name}.isobundle`);
  writeFileSync(path, volume.nrrd());
  await bench.command(bench.isosplat, ["build", path, "--labels", "-o", bundle]);
  return bundle;
}

async function layersOf(url: string, name: string): Promise<number> {
  const response = await fetch(`${url}v1/scenes/${name}`);
  return ((await response.json()) as { layers: number }).layers;
}

/** Visits with a cache that has the page but not the scene. */
async function visits(bench: Bench, browser: Browser, url: string, each: Case): Promise<void> {
  const [link] = links;
  if (!link) throw new Error("no link");
  const layers = await layersOf(url, each.name);
  const first: number[] = [];
  const all: number[] = [];
  const complete: number[] = [];
  const scripts: number[] = [];
  let requests = 0;
  for (let run = 0; run < Math.min(bench.runs, 5); ++run) {
    const visitor = await Visitor.arrive(browser, link);
    try {
      const at = `${url}?scene=${each.name}`;
      await visitor.page.goto(at);
      await visitor.mark("isosplat:surface", layers);
      await visitor.forgetData();
      const { requests: before } = visitor.data;
      await visitor.page.goto(at);
      first.push((await visitor.mark("isosplat:surface")).shown / 1000);
      all.push((await visitor.mark("isosplat:surface", layers)).shown / 1000);
      await visitor.page.waitForFunction(
        () => document.querySelector("[data-state=complete]") !== null,
      );
      complete.push((await visitor.page.evaluate(() => performance.now())) / 1000);
      scripts.push((await visitor.mainThread()).scripts);
      requests = visitor.data.requests - before;
    } finally {
      await visitor.leave();
    }
  }
  const what = `${each.what}, ${link.name}`;
  bench.report(what, "first surface", "s", first);
  bench.report(what, "each label has a surface", "s", all, { atMost: each.within });
  bench.report(what, "complete", "s", complete);
  bench.report(what, "scripts on the main thread", "ms", scripts);
  bench.report(what, "until complete", "requests", requests);
}

export default {
  title: "scenes of many labels: the page in Chromium, over a throttled link",
  async run(bench) {
    const cases: Case[] = [
      { name: "organs", what: "105 labels, 317 × 317 × 835", volume: organs(), within: 1 },
      { name: "many", what: "1,000 labels, 200³", volume: manyLabels(1000), within: 2 },
    ];
    const bundles: string[] = [];
    for (const each of cases) {
      bench.say(`building ${each.name}`);
      bundles.push(await build(bench, each));
    }
    const url = await serve(bench, bundles);
    const browser = await launch();
    try {
      for (const each of cases) {
        bench.say(each.what);
        await visits(bench, browser, url, each);
      }
    } finally {
      await browser.close();
    }
  },
} satisfies Benchmark;
