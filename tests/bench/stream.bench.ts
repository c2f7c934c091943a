import { existsSync } from "node:fs";
import type { Browser } from "@playwright/test";
import { dragOverRange } from "../browser/support/in_page.ts";
import type { Bench, Benchmark } from "./harness/benchmark.ts";
import { dragPrepared, type PreparedDrag } from "./stream/prepared_drag.ts";
import { buildStore, serve } from "./stream/serving.ts";
import { type Link, launch, links, Visitor } from "./stream/visit.ts";
import { measureVtk, servePeer } from "./stream/vtk_js.ts";

interface Case {
  name: string;
  isovalue: number;
  /** Largest allowed MB until the default view is complete. */
  reach?: number;
  /** Longest allowed time in s until then, over 20 Mbit/s. */
  within?: number;
}

/** Visits with an empty cache, and with a cache that has the page but not the volume. */
async function visits(
  bench: Bench,
  browser: Browser,
  url: string,
  { name, isovalue, reach, within }: Case,
  link: Link,
  runs: number,
): Promise<void> {
  const what = `${name} ${isovalue}, ${link.name}`;
  const at = `${url}?volume=${name}&isovalue=${isovalue}`;
  const cold: number[] = [];
  const warm: number[] = [];
  const complete: number[] = [];
  const longest: number[] = [];
  const drawing: number[] = [];
  const wire = { first: 0, firstRequests: 0, all: 0, requests: 0 };
  for (let run = 0; run < runs; ++run) {
    const visitor = await Visitor.arrive(browser, link);
    try {
      await visitor.page.goto(at);
      cold.push((await visitor.mark("isosplat:surface")).shown / 1000);
      await visitor.mark("isosplat:complete");
      // The volume's bytes are fetched again, but not the page's.
      await visitor.forgetData();
      const before = { ...visitor.data };
      await visitor.page.goto(at);
      const first = await visitor.mark("isosplat:surface");
      warm.push(first.shown / 1000);
      complete.push((await visitor.mark("isosplat:complete")).shown / 1000);
      longest.push((await visitor.work("isosplat:streaming")).longest);
      drawing.push((await visitor.work("isosplat:drawing")).longest);
      const detail = await visitor.markDetail("isosplat:surface");
      wire.first = detail.bytesReceived / 1000;
      wire.firstRequests = detail.requests;
      wire.all = (visitor.data.bytes - before.bytes) / 1e6;
      wire.requests = visitor.data.requests - before.requests;
    } finally {
      await visitor.leave();
    }
  }
  const isEngine20 = name === "engine" && link.megabitsPerSecond === 20;
  bench.report(
    what,
    "first surface, nothing cached",
    "s",
    cold,
    isEngine20 ? { atMost: 1 } : undefined,
  );
  bench.report(
    what,
    "first surface, page cached",
    "s",
    warm,
    isEngine20 ? { atMost: 0.5 } : undefined,
  );
  const completeIn = link.megabitsPerSecond === 20 ? within : undefined;
  bench.report(
    what,
    "complete, page cached",
    "s",
    complete,
    completeIn ? { atMost: completeIn } : undefined,
  );
  bench.report(what, "main thread, longest piece of streaming work", "ms", longest, { atMost: 8 });
  bench.report(what, "main thread, longest call that draws", "ms", drawing);
  bench.report(what, "until the first surface", "KB", wire.first, { atMost: 150 });
  bench.report(what, "until the first surface", "requests", wire.firstRequests, { atMost: 6 });
  bench.report(what, "until complete", "MB", wire.all, reach ? { atMost: reach } : undefined);
  bench.report(what, "until complete", "requests", wire.requests);
}

/** Drags the slider over the whole range in 5 s. */
async function drag(bench: Bench, browser: Browser, url: string, name: string): Promise<void> {
  const visitor = await Visitor.arrive(browser, links[0]);
  try {
    await visitor.page.goto(`${url}?volume=${name}`);
    await visitor.mark("isosplat:complete");
    const before = visitor.data.requests;
    const urlsBefore = visitor.urls.length;
    await visitor.page.evaluate(dragOverRange, 5);
    bench.report(
      `${name}, dragged over the range in 5 s`,
      "requests",
      "1/s",
      (visitor.data.requests - before) / 5,
      {
        atMost: 10,
      },
    );
    const chunks = visitor.urls.slice(urlsBefore).flatMap((address) => {
      const [, list] = /batch\?chunks=(.*)/.exec(decodeURIComponent(address)) ?? [];
      return list?.split(",") ?? [];
    });
    const repeated = chunks.length - new Set(chunks).size;
    bench.report(`${name}, dragged over the range in 5 s`, "chunks asked for twice", "", repeated, {
      atMost: 0,
    });
  } finally {
    await visitor.leave();
  }
}

/** Shows adjacent isovalues within the resident bands, one per frame. */
async function step(bench: Bench, browser: Browser, url: string, name: string): Promise<void> {
  const visitor = await Visitor.arrive(browser, links[0]);
  const what = `${name} 60.5, isovalue changed within its bands`;
  try {
    await visitor.page.goto(`${url}?volume=${name}&isovalue=60.5`);
    await visitor.mark("isosplat:prepared");
    // When the page is idle, it takes the preview picture for the list of volumes.
    await visitor.page.waitForTimeout(3000);
    const before = visitor.data.requests;
    // Each isovalue is a step of the slider, so each is a change. Bands end at whole quantized values.
    const places = Array.from({ length: 40 }, (_, i) => (60 + (i % 2) / 2) / 255);
    const taken = async () => ({
      ...(await visitor.mainThread()),
      processor: (await visitor.processorTime()).scripts,
      drawing: (await visitor.work("isosplat:drawing")).total,
      streaming: (await visitor.work("isosplat:streaming")).total,
    });
    const first = await taken();
    await visitor.slide(places, 2);
    const last = await taken();
    const each = (what: keyof typeof first): number => (last[what] - first[what]) / places.length;
    bench.report(what, "requests", "", visitor.data.requests - before, { atMost: 0 });
    const beside = each("scripts") - each("drawing");
    bench.report(what, "scripts on the main thread beside drawing", "ms", beside, { atMost: 1 });
    bench.report(what, "scripts with drawing, processor time", "ms", each("processor"));
    bench.report(what, "of it streaming", "ms", each("streaming"));
    bench.report(what, "calls that draw", "ms", each("drawing"));
    bench.report(what, "layout and styles of the page", "ms", each("layout"));
  } finally {
    await visitor.leave();
  }
}

const preparedDrags: PreparedDrag[] = [
  { name: "engine", isovalue: 60.5, reach: 4 },
  { name: "bonsai", isovalue: 71.5, reach: 4 },
  { name: "aneurysm", isovalue: 150.5, reach: 4 },
  { name: "bunny_ct_i16", isovalue: 1000.5, reach: 8 },
];

export default {
  title: "streaming: the page in Chromium, over throttled links",
  async run(bench) {
    const cases: Case[] = [];
    const stores: string[] = [];
    const add = async (file: string, found: Case): Promise<string | undefined> => {
      const volume = bench.volume(file);
      if (!volume) return undefined;
      stores.push(await buildStore(bench, volume, found.name));
      cases.push(found);
      return volume;
    };
    const engine = await add("engine.nhdr", {
      name: "engine",
      isovalue: 60.5,
      reach: 0.5,
      within: 0.8,
    });
    await add("bunny_ct_i16.nrrd", {
      name: "bunny_ct_i16",
      isovalue: 1000.5,
      reach: 3.8,
      within: 3,
    });
    await add("chris_t1.nii.gz", { name: "chris_t1", isovalue: 70.5, within: 2 });
    // A generated volume of 1024³, as a store: building one takes minutes.
    const large = process.env.ISOSPLAT_BENCH_LARGE_STORE;
    if (large && existsSync(large)) {
      stores.push(large);
      const isovalue = Number(process.env.ISOSPLAT_BENCH_LARGE_ISOVALUE ?? 226.5);
      const name = large.replace(/^.*\//, "").replace(/\.isosplat$/, "");
      cases.push({ name, isovalue, reach: 4 });
    } else {
      bench.skip("a volume of 1024³", "ISOSPLAT_BENCH_LARGE_STORE names no store");
    }
    if (stores.length === 0) return;
    const drawn = new Set(cases.map(({ name }) => name));
    for (const name of ["bonsai", "aneurysm"]) {
      const volume = bench.volume(`${name}.nhdr`);
      if (volume) stores.push(await buildStore(bench, volume, name));
      if (volume) drawn.add(name);
    }
    const url = await serve(bench, stores);
    const browser = await launch();
    try {
      const runs = Math.max(1, Math.min(bench.runs, 5));
      for (const link of links) {
        for (const each of cases) {
          bench.say(`${each.name}, ${link.name}`);
          await visits(bench, browser, url, each, link, runs);
        }
      }
      if (!engine) return;
      await drag(bench, browser, url, "engine");
      for (const each of preparedDrags) {
        bench.say(`${each.name}, dragged after 10 s`);
        if (drawn.has(each.name)) await dragPrepared(bench, browser, url, each, links[0]);
      }
      await step(bench, browser, url, "engine");
      const peer = await servePeer(bench, engine);
      if (!peer) return;
      try {
        bench.say("vtk.js");
        for (const link of links) await measureVtk(bench, browser, peer, link, Math.min(runs, 3));
      } finally {
        peer.server.close();
      }
    } finally {
      await browser.close();
    }
  },
} satisfies Benchmark;
