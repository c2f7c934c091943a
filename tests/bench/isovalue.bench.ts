// The time from a change of the isovalue to the final picture, in the page in Chromium over throttled links:
// with the data saver on, so that nothing is fetched ahead, and once the store is read ahead.
import type { Browser } from "@playwright/test";
import { saveData } from "../browser/support/in_page.ts";
import type { Bench, Benchmark } from "./harness/benchmark.ts";
import { buildStore, serve } from "./stream/serving.ts";
import { type Link, launch, links, Visitor } from "./stream/visit.ts";

interface Case {
  name: string;
  file: string;
  isovalue: number;
  /** Positions of the slider, from 0 to 1, one after the other. */
  places: readonly number[];
}

const cases: Case[] = [
  { name: "engine", file: "engine.nhdr", isovalue: 60.5, places: [0.4, 0.63, 0.3, 0.5, 0.75] },
  { name: "bonsai", file: "bonsai.nhdr", isovalue: 71.5, places: [0.4, 0.55, 0.2, 0.35, 0.7] },
];

/** Time for reading ahead over the faster link (ms). */
const pause = 10_000;
/** Time before each change (ms). */
const look = 1500;
/** Duration of a drag over all isovalues (ms). */
const drag = 3000;

/** Does something in the page. Returns the seconds from its end until its marks. */
async function after(
  visitor: Visitor,
  act: () => Promise<number>,
): Promise<{ complete: number; final: number }> {
  const ended = await act();
  const handle = await visitor.page.waitForFunction(
    (ended) => {
      const { visit } = globalThis as unknown as { visit: { name: string; at: number }[] };
      const final = visit.find(({ name, at }) => name === "isosplat:final" && at > ended);
      const complete = visit.find(({ name, at }) => name === "isosplat:complete" && at > ended);
      // A view that was complete before its last change may need no other chunks.
      return final && { complete: complete?.at ?? ended, final: final.at };
    },
    ended,
    { timeout: 60_000, polling: 20 },
  );
  const { complete, final } = (await handle.jsonValue()) as { complete: number; final: number };
  return { complete: (complete - ended) / 1000, final: (final - ended) / 1000 };
}

/** Sets the isovalue. Returns the time of the input (ms). */
function set(visitor: Visitor, place: number): Promise<number> {
  return visitor.page.evaluate((place) => {
    const slider = document.querySelector<HTMLInputElement>(".isovalue-slider");
    if (!slider) throw new Error("the page has no isovalue slider");
    const [low, high] = [Number(slider.min), Number(slider.max)];
    slider.valueAsNumber = low + place * (high - low);
    slider.dispatchEvent(new Event("input", { bubbles: true }));
    return performance.now();
  }, place);
}

/** Drags the isovalue over its range to a position. Returns the time of the last input (ms). */
function dragTo(visitor: Visitor, place: number): Promise<number> {
  return visitor.page.evaluate(
    async ({ place, drag }) => {
      const slider = document.querySelector<HTMLInputElement>(".isovalue-slider");
      if (!slider) throw new Error("the page has no isovalue slider");
      const [low, high] = [Number(slider.min), Number(slider.max)];
      const begin = performance.now();
      for (let t = 0; t < 1; ) {
        t = Math.min(1, (performance.now() - begin) / drag);
        slider.valueAsNumber = high + t * (low + place * (high - low) - high);
        slider.dispatchEvent(new Event("input", { bubbles: true }));
        if (t < 1) await new Promise((resolve) => requestAnimationFrame(resolve));
      }
      return performance.now();
    },
    { place, drag },
  );
}

async function measure(
  bench: Bench,
  browser: Browser,
  url: string,
  { name, isovalue, places }: Case,
  link: Link,
): Promise<void> {
  const isFast = link === links[0];
  const what = `${name}, ${link.name}`;
  const address = `${url}?volume=${name}&isovalue=${isovalue}`;
  const changes = async (visitor: Visitor): Promise<number[]> => {
    const times: number[] = [];
    for (const place of places) {
      await visitor.page.waitForTimeout(look);
      times.push((await after(visitor, () => set(visitor, place))).final);
    }
    return times;
  };
  const saver = await Visitor.arrive(browser, link);
  try {
    await saver.page.addInitScript(saveData);
    await saver.page.goto(address);
    await saver.mark("isosplat:complete");
    const atMost = isFast ? { atMost: 0.9 } : undefined;
    bench.report(
      what,
      "another isovalue, nothing fetched ahead",
      "s",
      await changes(saver),
      atMost,
    );
  } finally {
    await saver.leave();
  }
  const visitor = await Visitor.arrive(browser, link);
  try {
    await visitor.page.goto(address);
    await visitor.mark("isosplat:complete");
    bench.report(what, "until the first complete picture", "MB", visitor.data.bytes / 1e6);
    if (isFast) await visitor.page.waitForTimeout(pause);
    else await visitor.mark("isosplat:kept");
    bench.report(what, "until the store is read ahead", "MB", visitor.data.bytes / 1e6);
    const before = visitor.data.requests;
    bench.report(what, "another isovalue, later", "s", await changes(visitor), { atMost: 0.45 });
    const dragged: number[] = [];
    const finals: number[] = [];
    for (const place of places.slice(0, 3)) {
      await visitor.page.waitForTimeout(look);
      const { complete, final } = await after(visitor, () => dragTo(visitor, place));
      dragged.push(complete);
      finals.push(final);
    }
    bench.report(what, "full detail after a drag over the range, later", "s", dragged, {
      atMost: 0.3,
    });
    bench.report(what, "all later changes", "requests", visitor.data.requests - before, {
      atMost: 0,
    });
  } finally {
    await visitor.leave();
  }
}

export default {
  title: "another isovalue: the page in Chromium, over throttled links",
  async run(bench) {
    const stores: string[] = [];
    const found: Case[] = [];
    for (const each of cases) {
      const volume = bench.volume(each.file);
      if (!volume) continue;
      stores.push(await buildStore(bench, volume, each.name));
      found.push(each);
    }
    if (found.length === 0) return;
    const url = await serve(bench, stores);
    const browser = await launch();
    try {
      for (const link of links) {
        for (const each of found) {
          bench.say(`${each.name}, ${link.name}`);
          await measure(bench, browser, url, each, link);
        }
      }
    } finally {
      await browser.close();
    }
  },
} satisfies Benchmark;
