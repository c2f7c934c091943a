import { readdirSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import type { Browser } from "@playwright/test";
import { serveModules } from "../browser/support/empty_page.ts";
import { ballIsovalue, buildBall } from "../support/series.ts";
import type { Bench, Benchmark } from "./harness/benchmark.ts";
import { imageData } from "./harness/image_data.ts";
import { serve } from "./stream/serving.ts";
import { launch, links } from "./stream/visit.ts";
import { type Loop, playSeries } from "./time/played.ts";

interface Series {
  name: string;
  volumes: string[];
  isovalue: number;
}

const stepsPerSecond = 10;

/** 15 steps of 64³ voxels: the SciVis contest of 2016. */
async function fingers(bench: Bench): Promise<Series | undefined> {
  const folder = bench.volume("viscous_fingers");
  if (!folder) return undefined;
  const volumes: string[] = [];
  for (const file of readdirSync(folder).sort()) {
    const name = `fingers${volumes.length}`;
    const header =
      "NRRD0004\ntype: float\ndimension: 3\nsizes: 64 64 64\nendian: little\nencoding: raw\n\n";
    const volume = join(bench.folder, `${name}.nrrd`);
    writeFileSync(volume, Buffer.concat([Buffer.from(header), imageData(join(folder, file))]));
    await bench.command(bench.isosplat, ["build", volume, "-o", storeOf(bench, name)]);
    volumes.push(name);
  }
  return { name: "viscous_fingers, 15 × 64³", volumes, isovalue: 20 };
}

/** A ball that moves along a circle, and grows and shrinks. */
function balls(bench: Bench): Series {
  const [edge, count] = [256, 50];
  const volumes = Array.from({ length: count }, (_, step) => {
    const name = `ball${step}`;
    const turn = (2 * Math.PI * step) / count;
    const centre = [0.5 + 0.15 * Math.cos(turn), 0.5 + 0.15 * Math.sin(turn), 0.5] as const;
    buildBall(bench.folder, name, edge, { centre, radius: 0.25 + 0.05 * Math.sin(3 * turn) });
    return name;
  });
  return { name: `ball, ${count} × ${edge}³`, volumes, isovalue: ballIsovalue };
}

function storeOf(bench: Bench, name: string): string {
  return join(bench.folder, `${name}.isosplat`);
}

async function measure(bench: Bench, browser: Browser, series: Series): Promise<void> {
  const { name, volumes, isovalue } = series;
  const url = await serve(
    bench,
    volumes.map((volume) => storeOf(bench, volume)),
  );
  const modules = await serveModules(url);
  const [link] = links;
  if (!link) throw new Error("no link");
  try {
    const what = `${name}, ${link.name}`;
    const options = { origin: modules.origin, volumes, isovalue, rate: stepsPerSecond, link };
    const played = await playSeries(browser, options, 3);
    bench.report(what, "first step complete, and two ahead", "KB", played.firstBytes / 1000);
    bench.report(what, "first step complete, and two ahead", "requests", played.firstRequests);
    bench.report(what, "stated for all steps", "KB", played.costBytes / 1000);
    bench.report(what, "cells", "px", played.cellPixels);
    for (const [i, loop] of played.loops.entries()) {
      reportLoop(bench, what, i, loop, volumes.length);
    }
    const share = (100 * played.samples) / played.sampleBudget;
    bench.report(what, "most samples resident", "% of the budget", share, { atMost: 100 });
  } finally {
    await modules.close();
  }
}

function reportLoop(bench: Bench, what: string, i: number, loop: Loop, steps: number): void {
  const at = (measure: string) => `loop ${i + 1}: ${measure}`;
  const rate = steps / loop.seconds;
  bench.report(what, at("rate"), "steps/s", rate, { atLeast: 0.95 * stepsPerSecond });
  bench.report(what, at("bytes"), "KB", loop.bytes / 1000, i > 0 ? { atMost: 0 } : undefined);
  bench.report(what, at("requests"), "requests", loop.requests, i > 0 ? { atMost: 0 } : undefined);
  bench.report(what, at("stops for data"), "", loop.stops, { atMost: 0 });
  bench.report(what, at("stopped"), "s", loop.stopped);
  bench.report(what, at("frames"), "", loop.frames);
  bench.report(what, at("frames without a surface"), "", loop.blank, { atMost: 0 });
  bench.report(what, at("steps not drawn"), "", loop.undrawn, { atMost: 0 });
}

export default {
  title: "playing series: rate, requests and bytes of each loop",
  async run(bench) {
    const browser = await launch();
    try {
      const real = await fingers(bench);
      if (real) await measure(bench, browser, real);
      bench.say("building 50 volumes of 256³");
      await measure(bench, browser, balls(bench));
    } finally {
      await browser.close();
    }
  },
} satisfies Benchmark;
