// Compares complete pictures of the page with those that the native renderer draws of all samples at
// level 0, the level that these camera views resolve. Differing: pixels that differ by more than 60,
// summed over R, G and B. Stray: covered pixels further than 1 px from any covered pixel of the
// native picture; lost: the reverse. Also lists the bytes fetched until the picture is complete.
import { join } from "node:path";
import {
  completeAndSettled,
  differenceFrom,
  maxDiffering,
  nativePicture,
  pageSize,
  queryOf,
  trueCases,
} from "../browser/support/truth.ts";
import type { Bench, Benchmark } from "./harness/benchmark.ts";
import { buildStore, serve } from "./stream/serving.ts";
import { launch, Visitor } from "./stream/visit.ts";

const canvas = { width: 944, height: 748 };
/** Only views whose names match are compared; a name is, for example, "bonsai 150.5, aside". */
const wanted = new RegExp(process.env.ISOSPLAT_BENCH_TRUTH ?? "");

async function measure(bench: Bench, visitor: Visitor, what: string, truth: Buffer): Promise<void> {
  await completeAndSettled(visitor.page, 300_000);
  const found = await differenceFrom(visitor.page, truth);
  const most = Math.floor(maxDiffering * found.covered);
  bench.report(what, "covered", "px", found.covered);
  bench.report(what, "differing", "px", found.differing, { atMost: most });
  bench.report(what, "stray", "px", found.stray, { atMost: 0 });
  bench.report(what, "lost", "px", found.lost);
  const { bytesReceived } = await visitor.markDetail("isosplat:complete");
  bench.report(what, "until complete", "KB", bytesReceived / 1000);
}

/** Orbits to the right and back to exactly the same view. */
async function dragAndBack({ page }: Visitor): Promise<void> {
  await page.mouse.move(400, 300);
  await page.mouse.down();
  for (let step = 1; step <= 20; ++step) await page.mouse.move(400 + 5 * step, 300 + 2 * step);
  for (let step = 19; step >= 0; --step) await page.mouse.move(400 + 5 * step, 300 + 2 * step);
  await page.mouse.up();
}

export default {
  title: "the page's complete pictures against all samples, 944 × 748",
  async run(bench) {
    const stores = new Map<string, string>();
    for (const { name, file, isovalue, views } of trueCases) {
      const isWanted = Object.keys(views).some((view) =>
        wanted.test(`${name} ${isovalue}, ${view}`),
      );
      if (!isWanted || stores.has(name)) continue;
      const volume = bench.volume(file);
      if (volume) stores.set(name, await buildStore(bench, volume, name));
    }
    if (stores.size === 0) return;
    const url = await serve(bench, [...stores.values()]);
    const browser = await launch();
    try {
      for (const each of trueCases) {
        const store = stores.get(each.name);
        if (!store) continue;
        for (const [view, camera] of Object.entries(each.views)) {
          const what = `${each.name} ${each.isovalue}, ${view}`;
          if (!wanted.test(what)) continue;
          bench.say(what);
          const truth = nativePicture(store, each, camera, canvas, join(bench.folder, "truth.png"));
          const visitor = await Visitor.arrive(browser, undefined, pageSize(canvas));
          visitor.page.setDefaultTimeout(300_000);
          try {
            await visitor.page.goto(url + queryOf(each, camera));
            await measure(bench, visitor, what, truth);
            await dragAndBack(visitor);
            await measure(bench, visitor, `${what}, dragged and back`, truth);
          } finally {
            await visitor.leave();
          }
        }
      }
    } finally {
      await browser.close();
    }
  },
} satisfies Benchmark;
