// The viewer embedded in another page: it may be disposed at any time, and its workers may crash.
import { expect, type Page, test } from "@playwright/test";
import type * as StreamModule from "../../web/stream/index.ts";
import type * as ViewerModule from "../../web/viewer/index.ts";
import { type ServedModules, serveModules } from "./support/empty_page.ts";
import { demoFolder, type RunningServer, serve } from "./support/server.ts";

let server: RunningServer;
let modules: ServedModules;
test.beforeAll(async () => {
  server = await serve([demoFolder]);
  modules = await serveModules(server.url);
});
test.afterAll(async () => {
  await modules.close();
  await server.stop();
});

/** Variables that the tests keep in their page. */
declare global {
  interface Window {
    life: {
      viewer: ViewerModule.Viewer;
      source: StreamModule.Source;
      events: string[];
      opened: Promise<string>;
      complete: Promise<void>;
    };
  }
}

/** An empty page with a canvas and a viewer that has not opened anything. */
async function emptyPage(page: Page): Promise<void> {
  await page.goto(`${modules.origin}/empty`);
  await page.evaluate(async (base) => {
    const { Viewer }: typeof ViewerModule = await import(`${base}/viewer/index.ts`);
    const { ServerSource }: typeof StreamModule = await import(`${base}/stream/index.ts`);
    const canvas = document.querySelector("canvas");
    if (!canvas) throw new Error("no canvas");
    canvas.style.cssText = "width: 300px; height: 300px";
    const viewer = new Viewer(canvas);
    const events: string[] = [];
    viewer.on("opened", () => events.push("opened"));
    viewer.on("error", (error) => events.push(`error: ${error.message}`));
    viewer.on("progress", () => events.push("progress"));
    const source = new ServerSource({ base, volume: "bucky" });
    const unset = Promise.resolve("");
    window.life = { viewer, source, events, opened: unset, complete: Promise.resolve() };
  }, modules.origin);
}

/** `disposes`: the viewer is disposed in the same task, before any response. */
const open = (page: Page, disposes = false) =>
  page.evaluate((goes) => {
    const { viewer, source } = window.life;
    window.life.complete = new Promise((resolve) => {
      viewer.on("progress", ({ complete }) => complete && resolve());
    });
    window.life.opened = viewer
      .open(source, { surfaces: [{ isovalue: 100, colour: "#d0c0b0", opacity: 1 }] })
      .then(
        () => "opened",
        (error: unknown) => (error instanceof Error ? error.name : String(error)),
      );
    if (goes) viewer.dispose();
  }, disposes);

const dispose = (page: Page) => page.evaluate(() => window.life.viewer.dispose());
const outcome = (page: Page) => page.evaluate(() => window.life.opened);

/** Nothing of the viewer remains: no worker, no request, no event. */
async function expectGone(page: Page): Promise<void> {
  await expect.poll(() => page.workers().length).toBe(0);
  const events = await page.evaluate(() => window.life.events.length);
  const urls: string[] = [];
  page.on("request", (request) => urls.push(request.url()));
  // Any remaining work would run in the next frames.
  await page.evaluate(async () => {
    for (let i = 0; i < 10; ++i) await new Promise((next) => requestAnimationFrame(next));
  });
  expect(urls).toEqual([]);
  expect(await page.evaluate(() => window.life.events.length)).toBe(events);
  const again = await page.evaluate(() =>
    window.life.viewer.open(window.life.source).then(
      () => "opened",
      (error: unknown) => (error as Error).message,
    ),
  );
  expect(again).toContain("disposed");
}

test("a view that the sample budget keeps coarse is limited, and never complete", async ({
  page,
}) => {
  await emptyPage(page);
  const seen = await page.evaluate(async (base) => {
    const { Viewer }: typeof ViewerModule = await import(`${base}/viewer/index.ts`);
    window.life.viewer.dispose();
    const canvas = document.createElement("canvas");
    canvas.style.cssText = "width: 300px; height: 300px";
    document.body.append(canvas);
    // Level 0 has 92,772 active cells for this isovalue, level 1 about a quarter of that.
    const viewer = new Viewer(canvas, { sampleBudget: 20_000 });
    const states = new Set<string>();
    const limited = new Promise<{ samples: number; limited: boolean }>((resolve) =>
      viewer.on("progress", ({ state, samplesResident, limitedByBudget }) => {
        states.add(state);
        if (state === "limited") resolve({ samples: samplesResident, limited: limitedByBudget });
      }),
    );
    await viewer.open(window.life.source);
    viewer.setIsovalues([100]);
    const end = await limited;
    // The view stays limited, whatever further occlusion queries find.
    for (let i = 0; i < 60; ++i) await new Promise((next) => requestAnimationFrame(next));
    viewer.dispose();
    return { ...end, states: [...states] };
  }, modules.origin);
  expect(seen.limited).toBe(true);
  expect(seen.samples).toBeLessThanOrEqual(20_000);
  expect(seen.states).not.toContain("complete");
});

test.describe("a viewer that is disposed while a volume opens", () => {
  test("before its program has loaded", async ({ page }) => {
    let release = () => {};
    const held = new Promise<void>((resolve) => {
      release = resolve;
    });
    // The program itself, not the module with its address.
    const isProgram = ({ pathname, searchParams }: URL) =>
      pathname.endsWith("/isosplat-renderer.wasm") && !searchParams.has("import");
    await page.route(isProgram, async (route) => {
      await held;
      await route.continue().catch(() => {}); // the page may be closed
    });
    await emptyPage(page);
    await open(page);
    await dispose(page);
    release();
    expect(await outcome(page)).toBe("AbortError");
    await expectGone(page);
  });

  test("before the store's header has loaded", async ({ page }) => {
    let resolveRequested = () => {};
    const isRequested = new Promise<void>((resolve) => {
      resolveRequested = resolve;
    });
    let release = () => {};
    const held = new Promise<void>((resolve) => {
      release = resolve;
    });
    await page.route("**/v1/volumes/**", async (route) => {
      resolveRequested();
      await held;
      await route.continue().catch(() => {}); // the request was aborted
    });
    await emptyPage(page);
    await open(page);
    await isRequested;
    await dispose(page);
    expect(await outcome(page)).toBe("AbortError");
    release();
    await expectGone(page);
  });

  test("as soon as it is open, while chunks are loading", async ({ page }) => {
    await emptyPage(page);
    await open(page);
    await page.evaluate(async () => {
      await window.life.opened;
      window.life.viewer.dispose();
    });
    expect(await outcome(page)).toBe("opened");
    await expectGone(page);
  });

  test("and another viewer of the same page works", async ({ page }) => {
    await emptyPage(page);
    await open(page, true);
    expect(await outcome(page)).toBe("AbortError");
    await emptyPage(page);
    await open(page);
    expect(await outcome(page)).toBe("opened");
    await page.evaluate(() => window.life.complete);
  });
});

test("decoding workers that crash are replaced, and the picture becomes complete", async ({
  page,
}) => {
  await emptyPage(page);
  await open(page);
  await page.evaluate(() => window.life.complete);
  const before = page.workers();
  expect(before.length).toBeGreaterThan(0);
  // Throws an error that is not caught, like an instance without memory.
  for (const worker of before) {
    const gone = worker.waitForEvent("close");
    await worker.evaluate(() => {
      setTimeout(() => {
        throw new Error("out of memory");
      });
    });
    await gone;
  }
  await expect.poll(() => page.workers().length).toBe(before.length);
  expect(page.workers().some((worker) => before.includes(worker))).toBe(false);
  await page.evaluate(async () => {
    const { viewer } = window.life;
    const complete = new Promise<void>((resolve) => {
      viewer.on("progress", (progress) => progress.complete && resolve());
    });
    viewer.setIsovalues([180]);
    await complete;
  });
  expect(
    await page.evaluate(() => window.life.events.filter((e) => e.startsWith("error"))),
  ).toEqual([]);
});

test("a change of the light is a motion: fast splats first, then the exact surface", async ({
  page,
}) => {
  await emptyPage(page);
  await open(page);
  const kinds = await page.evaluate(async () => {
    const { viewer } = window.life;
    const atRest = () =>
      new Promise<void>((resolve) => {
        const stop = viewer.on("busy", (isBusy) => {
          if (isBusy) return;
          stop();
          resolve();
        });
      });
    await window.life.opened;
    if (viewer.isBusy) await atRest();
    const drawn: string[] = [];
    viewer.on("frame", ({ kind }) => drawn.push(kind));
    const isDone = atRest();
    viewer.setLook({ light: { ...viewer.look.light, azimuth: 30 } });
    await isDone;
    return drawn;
  });
  expect(kinds[0]).not.toBe("exact");
  expect(kinds.at(-1)).toBe("exact");
  await dispose(page);
});
