// A scene that changes with time, in a viewer: every frame shows one step of all layers.
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { expect, type Page, test } from "@playwright/test";
import type * as StreamModule from "../../web/stream/index.ts";
import type * as ViewerModule from "../../web/viewer/index.ts";
import { ballIsovalue, buildBall } from "../support/series.ts";
import { type ServedModules, serveModules } from "./support/empty_page.ts";
import { type RunningServer, serve } from "./support/server.ts";

const steps = 8;
const centre = (step: number) => 0.25 + (0.5 * step) / (steps - 1);

let folder: string;
let server: RunningServer;
let modules: ServedModules;
test.beforeAll(async () => {
  folder = mkdtempSync(join(tmpdir(), "isosplat-time-"));
  for (let step = 0; step < steps; ++step) {
    // Two layers, one above the other, that move together.
    for (const [layer, z] of [
      ["low", 0.27],
      ["high", 0.73],
    ] as const) {
      const ball = { centre: [centre(step), 0.5, z] as const, radius: 0.17 };
      buildBall(folder, `${layer}${step}`, 72, ball);
    }
  }
  server = await serve([folder]);
  modules = await serveModules(server.url);
});
test.afterAll(async () => {
  await modules?.close();
  await server?.stop();
  rmSync(folder, { recursive: true, force: true });
});

interface Seen {
  step: number;
  /** The positions of both balls in the picture, in pixels from the left; NaN if one is not drawn. */
  low: number;
  high: number;
}
interface Lab {
  viewer: ViewerModule.Viewer;
  /** The positions that each frame has shown. */
  frames: Seen[];
  events: string[];
  requests(): number;
  settled(): Promise<void>;
}
declare global {
  interface Window {
    lab: Lab;
  }
}

async function open(page: Page, options: ViewerModule.ViewerOptions = {}, step = 0): Promise<void> {
  await page.goto(`${modules.origin}/empty`);
  await page.evaluate(
    async ({ base, options, isovalue, count, step }) => {
      const viewerModule: typeof ViewerModule = await import(`${base}/viewer/index.ts`);
      const { ServerSource }: typeof StreamModule = await import(`${base}/stream/index.ts`);
      const canvas = document.querySelector("canvas");
      if (!canvas) throw new Error("no canvas");
      canvas.style.cssText = "width: 300px; height: 300px";
      const viewer = new viewerModule.Viewer(canvas, { backgroundBytes: 0, ...options });
      const sources: StreamModule.Source[] = [];
      const sourceOf = (name: string) => (at: number) => {
        const source = new ServerSource({ base, volume: `${name}${at}` });
        sources.push(source);
        return source;
      };
      const context = new OffscreenCanvas(300, 300).getContext("2d", { willReadFrequently: true });
      if (!context) throw new Error("no context");
      const frames: Seen[] = [];
      const events: string[] = [];
      viewer.on("frame", () => {
        context.drawImage(canvas, 0, 0, 300, 300);
        const { data } = context.getImageData(0, 0, 300, 300);
        const sum = { low: [0, 0], high: [0, 0] };
        for (let i = 0; i < data.length; i += 4) {
          const [red = 0, , blue = 0] = data.subarray(i, i + 3);
          const of = red > blue + 40 ? sum.low : blue > red + 40 ? sum.high : undefined;
          if (!of) continue;
          of[0] = (of[0] ?? 0) + ((i / 4) % 300);
          of[1] = (of[1] ?? 0) + 1;
        }
        const mean = ([x = 0, n = 0]: number[]) => x / n;
        const shown = viewer.time?.step ?? -1;
        frames.push({ step: shown, low: mean(sum.low), high: mean(sum.high) });
      });
      viewer.setTime({ values: Array.from({ length: count }, (_, i) => 2 * i), unit: "s" }, step);
      viewer.time?.on("step", (to) => events.push(`step ${to}`));
      viewer.time?.on("play", (is) => events.push(is ? "play" : "pause"));
      viewer.on("layererror", ({ error }) => events.push(`layererror ${error.kind}`));
      viewer.on("error", (error) => events.push(`error ${error.kind}`));
      for (const [name, colour] of [
        ["low", "#e02020"],
        ["high", "#2020e0"],
      ] as const) {
        await viewer.addLayer(sourceOf(name), {
          name,
          surfaces: [{ isovalue, colour, opacity: 1 }],
        });
      }
      const camera = viewer.wholeView;
      if (camera) {
        viewer.setCamera({ ...camera, azimuth: 0, elevation: 0, projection: "orthographic" });
      }
      const settled = async () => {
        await new Promise((next) => requestAnimationFrame(next));
        while (viewer.isBusy) await new Promise((next) => setTimeout(next, 20));
      };
      const requests = () => sources.reduce((sum, source) => sum + source.requests, 0);
      window.lab = { viewer, frames, events, settled, requests };
      await settled();
    },
    { base: modules.origin, options, isovalue: ballIsovalue, count: steps, step },
  );
}

/** The positions of the balls at each step, in pictures at rest. */
const positions = (page: Page) =>
  page.evaluate(async (count) => {
    const { viewer, frames, settled } = window.lab;
    const shown: Seen[] = [];
    for (let step = 0; step < count; ++step) {
      await viewer.time?.setStep(step);
      await settled();
      const last = frames.at(-1);
      if (last) shown.push(last);
    }
    return shown;
  }, steps);

/** Plays until this many steps were drawn. */
const play = (page: Page, shown: number) =>
  page.evaluate(async (shown) => {
    const { viewer, frames, events } = window.lab;
    const { time } = viewer;
    if (!time) throw new Error("no time");
    frames.length = 0;
    events.length = 0;
    const from = window.lab.requests();
    const begin = performance.now();
    await new Promise<void>((resolve) => {
      let left = shown;
      const off = time.on("step", () => {
        if (--left > 0) return;
        off();
        resolve();
      });
      time.play();
    });
    time.pause();
    const seconds = (performance.now() - begin) / 1000;
    return {
      frames: [...frames],
      events: [...events],
      requests: window.lab.requests() - from,
      seconds,
    };
  }, shown);

test("every frame shows one step of all layers, and each step is drawn", async ({ page }) => {
  await open(page);
  const at = await positions(page);
  expect(at.map(({ step }) => step)).toEqual([0, 1, 2, 3, 4, 5, 6, 7]);
  const distance = ((at[7]?.low ?? 0) - (at[0]?.low ?? 0)) / (steps - 1);
  expect(distance).toBeGreaterThan(6);
  for (const { low, high } of at) expect(Math.abs(low - high)).toBeLessThan(2);
  await page.evaluate(() => {
    const { time } = window.lab.viewer;
    if (time) time.rate = 20;
    return time?.setStep(0);
  });

  const { frames, events } = await play(page, 3 * steps);
  expect(events.filter((event) => event.startsWith("step")).slice(0, 9)).toEqual(
    [1, 2, 3, 4, 5, 6, 7, 0, 1].map((step) => `step ${step}`),
  );
  for (const frame of frames) {
    const expected = at[frame.step]?.low ?? Number.NaN;
    expect(Math.abs(frame.low - expected), `low at step ${frame.step}`).toBeLessThan(distance / 2);
    expect(Math.abs(frame.high - expected), `high at step ${frame.step}`).toBeLessThan(
      distance / 2,
    );
  }
  // No step is left out.
  const drawn = frames.map(({ step }) => step).filter((step, i, all) => step !== all[i - 1]);
  expect(drawn.slice(1)).toEqual(drawn.slice(0, -1).map((step) => (step + 1) % steps));
  expect(new Set(drawn).size).toBe(steps);
});

test("a loop that fits into memory is fetched once", async ({ page }) => {
  await open(page);
  await page.evaluate(() => {
    const { time } = window.lab.viewer;
    if (time) time.rate = 10;
  });
  const first = await play(page, steps);
  expect(first.requests).toBeGreaterThan(0);
  // On a slow machine, steps are shown before they have their full detail.
  let loop = first;
  for (let i = 0; i < 8 && loop.requests > 0; ++i) loop = await play(page, steps);
  const next = await play(page, 2 * steps);
  expect(next.requests).toBe(0);
  expect(next.frames.every(({ low, high }) => low > 0 && high > 0)).toBe(true);
});

test("memory stays within its budget, and fetched bytes are kept", async ({ page }) => {
  // The coarse levels of a step, which stay resident, have about 43,000 samples.
  await open(page, { sampleBudget: 200_000 });
  await page.evaluate(() => {
    const { viewer } = window.lab;
    const { time } = viewer;
    if (time) time.rate = 10;
    Object.assign(window, { most: 0 });
    viewer.on("frame", ({ samplesResident }) => {
      const seen = window as unknown as { most: number };
      seen.most = Math.max(seen.most, samplesResident);
    });
  });
  const first = await play(page, steps);
  expect(first.requests).toBeGreaterThan(0);
  let last = first;
  for (let i = 0; i < 8 && last.requests > 0; ++i) last = await play(page, steps);
  expect(last.requests).toBe(0);
  expect(last.frames.every(({ low, high }) => low > 0 && high > 0)).toBe(true);
  const most = await page.evaluate(() => (window as unknown as { most: number }).most);
  expect(most).toBeGreaterThan(40_000);
  expect(most).toBeLessThanOrEqual(200_000);
});

test("isovalue, colour and visibility apply to every step", async ({ page }) => {
  await open(page);
  const seen = await page.evaluate(async () => {
    const { viewer, frames, settled, requests } = window.lab;
    const [low, high] = viewer.layers;
    if (!low || !high || !viewer.time) throw new Error("no layers");
    // The balls exchange their colours.
    low.surfaces = [{ isovalue: 100, colour: "#2020e0", opacity: 1 }];
    high.visible = false;
    await viewer.time.setStep(5);
    await settled();
    const hidden = frames.at(-1);
    const before = requests();
    await viewer.time.setStep(6);
    await settled();
    const names = requests() - before;
    high.visible = true;
    await settled();
    const shown = frames.at(-1);
    return { hidden, shown, names, step: viewer.time.step };
  });
  expect(seen.step).toBe(6);
  expect(seen.hidden?.step).toBe(5);
  expect(seen.hidden?.low).toBeNaN();
  expect(seen.hidden?.high).toBeGreaterThan(0);
  // Both are blue, and one is above the other at the same step.
  expect(seen.shown?.low).toBeNaN();
  expect(seen.shown?.high).toBeGreaterThan(seen.hidden?.high ?? 0);
});

test("a step whose store is missing is named, and playing continues", async ({ page }) => {
  await page.route(/\/volumes\/high3\//, (route) => route.fulfill({ status: 404, body: "gone" }));
  await open(page);
  await page.evaluate(() => {
    const { time } = window.lab.viewer;
    if (time) time.rate = 10;
  });
  const { frames, events } = await play(page, steps);
  expect(events.filter((event) => event.startsWith("step")).length).toBe(steps);
  expect(events).toContain("layererror not-found");
  const broken = frames.filter(({ step }) => step === 3);
  expect(broken.length).toBeGreaterThan(0);
  for (const { low, high } of broken) {
    expect(low).toBeGreaterThan(0);
    expect(high).toBeNaN();
  }
  expect(frames.filter(({ step }) => step === 4).every(({ high }) => high > 0)).toBe(true);
});

test("a scene can begin with any step, and continues after the context was lost", async ({
  page,
}) => {
  await open(page, {}, 4);
  const seen = await page.evaluate(async () => {
    const { viewer, frames, settled } = window.lab;
    const before = { ...frames.at(-1) };
    const first = viewer.time?.step;
    const loss = viewer.canvas.getContext("webgl2")?.getExtension("WEBGL_lose_context");
    const restored = new Promise<void>((resolve) => {
      viewer.on("context", (state) => state === "restored" && resolve());
    });
    loss?.loseContext();
    await new Promise((next) => setTimeout(next, 100));
    loss?.restoreContext();
    await restored;
    await settled();
    const after = { ...frames.at(-1) };
    await viewer.time?.setStep(5);
    await settled();
    return { first, before, after, next: frames.at(-1) };
  });
  expect(seen.first).toBe(4);
  expect(seen.after.step).toBe(4);
  expect(Math.abs((seen.after.low ?? 0) - (seen.before.low ?? 0))).toBeLessThan(2);
  expect(Math.abs((seen.after.high ?? 0) - (seen.before.high ?? 0))).toBeLessThan(2);
  expect(seen.next?.step).toBe(5);
  expect(seen.next?.low).toBeGreaterThan((seen.after.low ?? 0) + 5);
});
