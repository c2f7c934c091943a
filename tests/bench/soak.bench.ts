import type { Bench, Benchmark } from "./harness/benchmark.ts";
import { buildStore, serve } from "./stream/serving.ts";
import { launch, Visitor } from "./stream/visit.ts";

/** Duration of scripted use: ISOSPLAT_BENCH_SOAK_MINUTES. */
const minutes = Number(process.env.ISOSPLAT_BENCH_SOAK_MINUTES ?? 5);

/** One round of use: isovalues over the whole range, orbiting, zooming in and out. */
async function use(visitor: Visitor, round: number): Promise<void> {
  const { page } = visitor;
  for (let i = 0; i <= 10; ++i) await visitor.slide([0.05 + 0.09 * ((i * 7 + round) % 11)]);
  const canvas = await page.locator("canvas").first().boundingBox();
  if (!canvas) throw new Error("the page has no canvas");
  const [x, y] = [canvas.x + canvas.width / 2, canvas.y + canvas.height / 2];
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x + 60 + 10 * (round % 5), y + 20 * ((round % 3) - 1), { steps: 5 });
  await page.mouse.up();
  await page.mouse.wheel(0, round % 2 === 0 ? -240 : 240);
  await page.waitForTimeout(1500);
}

async function soak(bench: Bench, visitor: Visitor): Promise<void> {
  const held: { objects: number; buffers: number; wasm: number; samples: number }[] = [];
  let budget = 0;
  const end = Date.now() + minutes * 60_000;
  for (let round = 0; Date.now() < end; ++round) {
    await use(visitor, round);
    // Every second round zooms back, so that the distance does not drift.
    if (round % 2 === 0) continue;
    const detail = await visitor.markDetail("isosplat:complete");
    budget = detail.sampleBudget;
    held.push({ ...(await visitor.heap()), samples: detail.samplesResident / 1e6 });
    bench.say(
      `${Math.ceil((end - Date.now()) / 60_000)} min left: ${JSON.stringify(held.at(-1))} MB, M`,
    );
  }
  const third = Math.floor(held.length / 3);
  if (third === 0) throw new Error("too short: fewer than three measurements");
  const mean = (what: "objects" | "buffers" | "wasm", from: number): number =>
    held.slice(from, from + third).reduce((sum, entry) => sum + entry[what], 0) / third;
  const report = (what: string, unit: string, value: number, reach?: { atMost: number }): void =>
    bench.report(`engine, ${minutes} min of use`, what, unit, value, reach);
  report("samples held, most", "M", Math.max(...held.map(({ samples }) => samples)), {
    atMost: budget / 1e6,
  });
  for (const what of ["objects", "buffers", "wasm"] as const) {
    const [early, late] = [mean(what, third), mean(what, held.length - third)];
    report(`${what}, in the last third`, "MB", late);
    // The first third is not counted, because it fills caches.
    report(`${what}, last third by the second`, "×", late / early, { atMost: 1.05 });
  }
}

export default {
  title: "memory of the page in long use",
  async run(bench) {
    const volume = bench.volume("engine.nhdr");
    if (!volume) return;
    const url = await serve(bench, [await buildStore(bench, volume, "engine")]);
    const browser = await launch();
    try {
      const visitor = await Visitor.arrive(browser);
      await visitor.page.goto(`${url}?volume=engine&isovalue=60.5`);
      await visitor.mark("isosplat:complete");
      await soak(bench, visitor);
      await visitor.leave();
    } finally {
      await browser.close();
    }
  },
} satisfies Benchmark;
