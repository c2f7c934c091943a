/**
 * Everything goes wrong at once: between the page and the real server, or nginx, answers are delayed,
 * cut, changed, refused, or those of another store; the store is replaced and taken away; the WebGL
 * context is lost; and the visitor goes on meanwhile. Once it is over, the page shows the picture
 * of a page that nothing was done to, and says so; no request is repeated without end, and nothing
 * is held that was not before.
 *
 *   CHAOS_SECONDS=3600 CHAOS_SEED=7 npx playwright test chaos
 */
import { mkdtempSync, readFileSync, renameSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { type Browser, expect, type Page, test } from "@playwright/test";
import { FaultProxy } from "../support/fault_proxy.ts";
import { type Nginx, nginx } from "../support/nginx.ts";
import { anyFault, Chance, countHoldings, type Holdings } from "./support/chaos.ts";
import { demoFolder, type RunningServer, serve } from "./support/server.ts";
import { compare, complete, savedPicture, settled } from "./support/view.ts";

/** So long are new rounds begun (s); a round takes some 10 s. */
const seconds = Number(process.env.CHAOS_SECONDS ?? 20);
const firstSeed = Number(process.env.CHAOS_SEED ?? 1);
/** How long faults go on in a round (ms). */
const roundLength = 4000;
/** The invariant says 20 s on a machine that has nothing else to do. */
const longestRecovery = 120_000;
/** Edges of coarse stand-ins, which what was looked at before decides; see occlusion.browser.ts. */
const mostDiffering = 0.002;
const titles = [/bucky/i, /marschner/i];
const versions = ["bucky", "marschner_lobb"].map((name) => join(demoFolder, `${name}.isosplat`));

test.use({ viewport: { width: 640, height: 420 } });

let folder: string;
let server: RunningServer;
let host: Nginx;

test.beforeAll(async () => {
  folder = mkdtempSync(join(tmpdir(), "isosplat-chaos-"));
  put(0);
  server = await serve([folder]);
  host = await nginx({ folders: [folder] });
});
test.afterAll(async () => {
  await server.stop();
  await host.stop();
  rmSync(folder, { recursive: true, force: true });
});

const store = (): string => join(folder, "chaos.isosplat");

/** This version takes the place of whatever is there. */
function put(version: number): void {
  writeFileSync(`${store()}.part`, readFileSync(versions[version] ?? ""));
  renameSync(`${store()}.part`, store());
}

/** The same, and the server has seen it. */
async function putAndServe(version: number): Promise<void> {
  put(version);
  await expect
    .poll(async () => (await fetch(`${server.url}v1/volumes/chaos`)).text())
    .toMatch(titles[version] ?? "");
}

/** Which version the page shows. */
async function versionOf(page: Page): Promise<number> {
  const name = (await page.locator(".volume-name").textContent()) ?? "";
  const version = titles.findIndex((title) => title.test(name));
  expect(version, name).toBeGreaterThanOrEqual(0);
  return version;
}

async function slide(page: Page, share: number): Promise<void> {
  await page.evaluate((to) => {
    type Slider = HTMLElement & { value: number; min: number; max: number };
    const slider = document.querySelector<Slider>("wa-slider.isovalue-slider");
    if (!slider) return;
    slider.value = slider.min + to * (slider.max - slider.min);
    slider.dispatchEvent(new Event("input", { bubbles: true }));
  }, share);
}

/** The context goes, and comes back after so long (ms). */
async function loseContext(page: Page, milliseconds: number): Promise<void> {
  await page.evaluate((wait) => {
    const gl = document.querySelector<HTMLCanvasElement>("canvas.view")?.getContext("webgl2");
    const extension = gl?.getExtension("WEBGL_lose_context");
    if (!extension || gl?.isContextLost()) return;
    extension.loseContext();
    setTimeout(() => extension.restoreContext(), wait);
  }, milliseconds);
}

/** One thing that happens to the store, the page, or its visitor. */
async function happen(page: Page, chance: Chance): Promise<void> {
  switch (chance.whole(0, 7)) {
    case 0:
      put(chance.whole(0, versions.length - 1));
      return;
    case 1:
      renameSync(store(), `${store()}.away`);
      await page.waitForTimeout(chance.whole(0, 1500));
      renameSync(`${store()}.away`, store());
      return;
    case 2:
      await loseContext(page, chance.whole(0, 400));
      return;
    case 3:
    case 4:
      for (let step = chance.whole(2, 8); step > 0; --step) {
        await page.keyboard.press(chance.of(["ArrowLeft", "ArrowUp", "ArrowRight", "+", "-"]));
      }
      return;
    default:
      await slide(page, 0.2 + 0.6 * chance.next());
  }
}

/** The picture of this view on a page of its own that nothing is done to. */
async function undisturbed(browser: Browser, address: string): Promise<Buffer> {
  const context = await browser.newContext({ viewport: { width: 640, height: 420 } });
  const page = await context.newPage();
  await page.goto(address);
  await complete(page, longestRecovery);
  await settled(page, longestRecovery);
  const picture = await savedPicture(page);
  await context.close();
  return picture;
}

const holdings = (page: Page): Promise<Holdings> =>
  page.evaluate(() => (window as unknown as { holdings: () => Holdings }).holdings());

/** After a collection of garbage. */
async function heapBytes(page: Page): Promise<number> {
  const session = await page.context().newCDPSession(page);
  await session.send("HeapProfiler.collectGarbage");
  const { usedSize } = await session.send("Runtime.getHeapUsage");
  await session.detach();
  return usedSize;
}

for (const where of ["isosplat serve", "nginx"] as const) {
  test(`between the page and ${where}`, async ({ page, browser }) => {
    test.setTimeout(1000 * seconds + 600_000);
    const isServer = where !== "nginx";
    const proxy = new FaultProxy(isServer ? server.url : host.url);
    await proxy.start();
    const [through, straight] = isServer
      ? [`${proxy.url}/?volume=chaos`, `${server.url}?volume=chaos`]
      : [
          `${server.url}?src=${encodeURIComponent(`${proxy.url}/chaos.isosplat`)}`,
          `${server.url}?src=${encodeURIComponent(`${host.url}chaos.isosplat`)}`,
        ];
    const thrown: string[] = [];
    page.on("pageerror", (error) => thrown.push(String(error)));
    await page.addInitScript(countHoldings);
    const end = Date.now() + (1000 * seconds) / 2;
    let heapAtFirst = 0;
    try {
      // Which splats are drawn is not to depend on how fast they are.
      await page.goto(`${through}&kind=ellipse`);
      await complete(page, longestRecovery);
      await settled(page, longestRecovery);
      const before = { ...(await holdings(page)), workers: page.workers().length };
      for (let round = 0; round === 0 || Date.now() < end; ++round) {
        const seed = firstSeed + 1000 * round + (isServer ? 0 : 1);
        const chance = new Chance(seed);
        const share = 0.2 + 0.6 * chance.next();
        await test.step(`seed ${seed}: ${Math.round(100 * share)} % of the answers`, async () => {
          proxy.fault = (path) =>
            /^\/v1\/|\.isosplat$/.test(path) && chance.next() < share
              ? anyFault(chance)
              : undefined;
          await page.getByRole("application").focus();
          for (const until = Date.now() + roundLength; Date.now() < until; ) {
            await happen(page, chance);
            await page.waitForTimeout(chance.whole(0, 600));
          }
          proxy.fault = () => undefined;
        });

        // The state says that the picture is right, and nothing else is said.
        await complete(page, longestRecovery);
        await settled(page, longestRecovery);
        await expect(page.getByRole("alert")).toHaveCount(0);
        await expect(page.locator(".banner")).toHaveCount(0);
        await expect(page.locator("wa-spinner")).toHaveCount(0);
        const view = new URL(page.url()).searchParams;
        for (const name of ["volume", "src"]) view.delete(name);
        const ours = await savedPicture(page);
        // Of two versions it may show either: one that was whole before the other came is right.
        await putAndServe(await versionOf(page));
        const wanted = await undisturbed(browser, `${straight}&${view}`);
        const { differing } = await compare(page, ours, wanted);
        if (differing > mostDiffering) {
          for (const [name, body] of Object.entries({ ours, wanted })) {
            await test.info().attach(name, { body, contentType: "image/png" });
          }
        }
        expect(differing, `seed ${seed}: ${page.url()}`).toBeLessThanOrEqual(mostDiffering);

        // At rest nothing is asked for.
        const asked = proxy.asked.length;
        await page.waitForTimeout(1500);
        expect(proxy.asked.length).toBe(asked);
        expect(thrown).toEqual([]);
        expect(page.workers().length).toBeLessThanOrEqual(before.workers);
        const now = await holdings(page);
        expect(now.contexts).toBe(before.contexts);
        // Programs are made as they are needed, and buffers with the samples.
        expect(now.glObjects).toBeLessThanOrEqual(2 * before.glObjects + 20);
        const heap = await heapBytes(page);
        heapAtFirst ||= heap;
        expect(heap).toBeLessThan(1.5 * heapAtFirst + 10e6);
        proxy.asked.length = 0;
      }
    } finally {
      await proxy.stop();
    }
  });
}
