// Files that are dropped on the page, which builds their stores. Compares it with NiiVue, which
// draws the voxels.
import { readFileSync, writeFileSync } from "node:fs";
import { basename, dirname, join } from "node:path";
import type { Browser } from "@playwright/test";
import { drop } from "../browser/support/drop.ts";
import { zipOf } from "../support/zip_files.ts";
import { traceTasks } from "./drop/main_thread.ts";
import { serveNiiVue } from "./drop/niivue.ts";
import { MemoryWatch, processOf } from "./drop/processes.ts";
import type { Bench, Benchmark } from "./harness/benchmark.ts";
import { buildStore, serve } from "./stream/serving.ts";
import { launch, Visitor } from "./stream/visit.ts";

interface Case {
  name: string;
  /** The files that are dropped on the page. NiiVue accepts a single file. */
  files: string[];
  single: string;
  megavoxels: number;
  /** Seconds until the first surface, and until the store is built. */
  surface: number;
  built: number;
}

/** A page with an empty cache, which sets the mark bench:dropped when files are dropped on it. */
async function arrive(browser: Browser, url: string, ready: () => boolean): Promise<Visitor> {
  const visitor = await Visitor.arrive(browser);
  await visitor.page.addInitScript(() => {
    window.addEventListener("drop", () => performance.mark("bench:dropped"), { capture: true });
  });
  await visitor.page.goto(url);
  await visitor.page.waitForFunction(ready);
  await visitor.page.waitForLoadState("networkidle");
  return visitor;
}

// These are functions, because the page's policy forbids the evaluation of text.
const hasStartPage = (): boolean => document.querySelector(".device-drop") !== null;
const isPeerReady = (): boolean => performance.getEntriesByName("peer:ready").length > 0;

/** Seconds from an input of another isovalue until the GPU has finished the next picture. */
function changeIsovalue(visitor: Visitor): Promise<number> {
  return visitor.page.evaluate(async () => {
    const slider = document.querySelector<HTMLInputElement>(".isovalue-slider");
    const gl = document.querySelector<HTMLCanvasElement>("canvas.view")?.getContext("webgl2");
    if (!slider || !gl) throw new Error("the page has no isovalue slider, or no picture");
    const begin = performance.now();
    slider.valueAsNumber = Number(slider.min) + 0.5 * (Number(slider.max) - Number(slider.min));
    slider.dispatchEvent(new Event("input", { bubbles: true }));
    await new Promise((next) => requestAnimationFrame(next));
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
    return (performance.now() - begin) / 1000;
  });
}

async function measurePage(bench: Bench, url: string, volume: Case, runs: number): Promise<void> {
  const { name, files, megavoxels } = volume;
  const figures = { surface: [], built: [], rate: [], memory: [], change: [] } as Record<
    "surface" | "built" | "rate" | "memory" | "change",
    number[]
  >;
  const opening: number[] = [];
  const building: number[] = [];
  for (let run = 0; run < runs; ++run) {
    // Each run has a new browser, so that its memory is that of this page.
    const browser = await launch();
    try {
      const visitor = await arrive(browser, url, hasStartPage);
      const memory = new MemoryWatch(await processOf(browser));
      await drop(visitor.page, files);
      const built = await visitor.mark("isosplat:built");
      const dropped = await visitor.mark("bench:dropped");
      const surface = await visitor.mark("isosplat:surface");
      await visitor.controls();
      await visitor.page.waitForSelector(".task-card", { state: "detached", timeout: 60_000 });
      const seconds = (built.at - dropped.at) / 1000;
      figures.surface.push((surface.shown - dropped.at) / 1000);
      figures.built.push(seconds);
      figures.rate.push(megavoxels / seconds);
      figures.memory.push(memory.end());
      await visitor.page.waitForTimeout(3000); // the view is complete
      figures.change.push(await changeIsovalue(visitor));
    } finally {
      await browser.close();
    }
    const traced = await launch();
    try {
      const { page, ...visitor } = await traceVisit(traced, url);
      const longest = await traceTasks(traced, page, async () => {
        await drop(page, files);
        await visitor.mark("isosplat:built");
      });
      opening.push(longest("bench:dropped", "isosplat:built") ?? 0);
      // From the preview's complete picture on, the page opens nothing, and the build continues.
      const whileBuilding = longest("isosplat:complete", "isosplat:built");
      if (whileBuilding !== undefined) building.push(whileBuilding);
    } finally {
      await traced.close();
    }
  }
  bench.report(name, "dropped: first surface", "s", figures.surface, { atMost: volume.surface });
  bench.report(name, "dropped: store built", "s", figures.built, { atMost: volume.built });
  bench.report(name, "voxels by the time until built", "Mvoxel/s", figures.rate);
  bench.report(name, "memory of all processes, most", "MB", figures.memory, { atMost: 700 });
  bench.report(name, "main thread, longest task: the preview is opened", "ms", opening);
  if (building.length > 0) {
    const what = "main thread, longest task: the build alone";
    bench.report(name, what, "ms", building, { atMost: 8 });
  }
  bench.report(name, "first picture of another isovalue", "s", figures.change);
}

/** Measures the file in a ZIP, which the page decompresses. */
async function measureUnpacking(bench: Bench, url: string, volume: Case, runs: number) {
  const { name, single } = volume;
  const path = join(bench.folder, `${name}.zip`);
  writeFileSync(path, zipOf([{ name: basename(single), content: readFileSync(single) }]));
  const seconds: number[] = [];
  const tasks: number[] = [];
  for (let run = 0; run < runs; ++run) {
    const browser = await launch();
    try {
      const { page, mark } = await traceVisit(browser, url);
      const longest = await traceTasks(browser, page, async () => {
        await drop(page, [path]);
        const [dropped, unpacked] = [await mark("bench:dropped"), await mark("isosplat:unpacked")];
        seconds.push((unpacked.at - dropped.at) / 1000);
      });
      tasks.push(longest("bench:dropped", "isosplat:unpacked") ?? 0);
    } finally {
      await browser.close();
    }
  }
  bench.report(`${name}, in a ZIP`, "unpacked", "s", seconds);
  const what = "main thread, longest task until unpacked";
  bench.report(`${name}, in a ZIP`, what, "ms", tasks, { atMost: 8 });
}

async function traceVisit(browser: Browser, url: string) {
  const visitor = await arrive(browser, url, hasStartPage);
  return { page: visitor.page, mark: (name: string) => visitor.mark(name) };
}

async function measureNiiVue(bench: Bench, url: string, volume: Case, runs: number): Promise<void> {
  const image: number[] = [];
  const change: number[] = [];
  const megabytes: number[] = [];
  for (let run = 0; run < runs; ++run) {
    const browser = await launch();
    try {
      const visitor = await arrive(browser, url, isPeerReady);
      const memory = new MemoryWatch(await processOf(browser));
      await drop(visitor.page, [volume.single]);
      const shown = await visitor.mark("peer:image");
      const dropped = await visitor.mark("bench:dropped");
      image.push((shown.at - dropped.at) / 1000);
      megabytes.push(memory.end());
      await visitor.page.evaluate("changeIsovalue()");
      const [before, after] = [
        await visitor.mark("peer:change"),
        await visitor.mark("peer:changed"),
      ];
      change.push((after.at - before.at) / 1000);
    } finally {
      await browser.close();
    }
  }
  const what = `${volume.name}, NiiVue`;
  bench.report(what, "dropped: first image", "s", image);
  bench.report(what, "memory of all processes, most", "MB", megabytes);
  bench.report(what, "picture of another isovalue", "s", change);
}

/** The volume of a detached NRRD header as one file. */
function attached(bench: Bench, header: string): string {
  const text = readFileSync(header, "latin1");
  const data = /^data file: *(.*)$/m.exec(text)?.[1]?.trim() ?? "";
  const rest = text.replace(/^data file:.*\n/m, "").trimEnd();
  const path = join(bench.folder, "attached.nrrd");
  const voxels = readFileSync(join(dirname(header), data));
  writeFileSync(path, Buffer.concat([Buffer.from(`${rest}\n\n`, "latin1"), voxels]));
  return path;
}

export default {
  title: "volumes dropped on the page, whose stores it builds, beside NiiVue",
  async run(bench) {
    const cases: Case[] = [];
    const engine = bench.volume("engine.nhdr");
    if (engine) {
      const files = [engine, engine.replace(/\.nhdr$/, ".raw.gz")];
      const single = attached(bench, engine);
      cases.push({ name: "engine", files, single, megavoxels: 8.39, surface: 1, built: 1.5 });
    }
    const bunny = bench.volume("bunny_ct_i16.nrrd");
    if (bunny) {
      const name = "bunny_ct_i16";
      const files = [bunny];
      cases.push({ name, files, single: bunny, megavoxels: 94.6, surface: 4, built: 10 });
    }
    if (!engine) return;
    const url = await serve(bench, [await buildStore(bench, engine, "engine")]);
    const peer = await serveNiiVue(bench);
    const runs = Math.max(1, Math.min(bench.runs, 5));
    try {
      const wanted = process.env.ISOSPLAT_BENCH_DROP ?? "";
      for (const volume of cases.filter(({ name }) => name.includes(wanted))) {
        bench.say(volume.name);
        await measurePage(bench, url, volume, runs);
        await measureUnpacking(bench, url, volume, runs);
        if (peer) await measureNiiVue(bench, peer.url, volume, runs);
      }
    } finally {
      await peer?.server.close();
    }
  },
} satisfies Benchmark;
