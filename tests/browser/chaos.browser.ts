/**
 * Random faults at the same time: responses between the page and the real server, or nginx, are
 * delayed, truncated, changed, refused, or taken from another store; the store is replaced and
 * removed; the WebGL context is lost; and the visitor keeps using the page. Afterwards the page
 * must show the same picture as an undisturbed page, without a message. If a fault lasts, the page
 * must name it and send the same request at most once in ten seconds. No resources may leak. To run both tests
 * for half an hour each, with other faults:
 * CHAOS_SECONDS=1800 CHAOS_SEED=7 npx playwright test chaos
 */
import { mkdtempSync, readFileSync, renameSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { type Browser, expect, type Page, test } from "@playwright/test";
import { faults } from "../../web/stream/faults.ts";
import { Chance } from "../support/chance.ts";
import { FaultProxy } from "../support/fault_proxy.ts";
import { type Nginx, nginx } from "../support/nginx.ts";
import { anyFault, ChanceOfEach } from "./support/chaos.ts";
import { countHoldings, type Holdings, heapBytes, holdingsOf } from "./support/holdings.ts";
import { isOfData, type LastingFault, lastingFaults, titleOf } from "./support/lasting_faults.ts";
import { RequestLog } from "./support/request_log.ts";
import { demoFolder, type RunningServer, serve } from "./support/server.ts";
import { compare, complete, savedPicture, settled } from "./support/view.ts";

/**
 * The time during which each test starts new rounds (s). By default, each test has one round, so
 * its faults are always the same. A round takes about 10 s, or a minute with a lasting fault.
 */
const seconds = Number(process.env.CHAOS_SECONDS ?? 0);
const firstSeed = Number(process.env.CHAOS_SEED ?? 1);
/** Number of events of a round, and the longest time between them (ms). */
const eventsPerRound = 12;
const longestPause = 600;
/** One of this many rounds ends with a lasting fault. */
const roundsToLasting = 2;
/** Time limit of recovery (s). An idle machine must manage 20 s: CHAOS_RECOVERY=20. */
const longestRecovery = 1000 * Number(process.env.CHAOS_RECOVERY ?? 120);
/** After this time (ms), fast retries have reached their longest interval. */
const warmUp = 28_000;
/** Period (ms) in which repeated requests are counted. It is longer than the longest interval. */
const watch = 20_000;
const shortestGap = 10_000;
/**
 * Number of pixels that may differ: where two splats have the same depth, the one that was drawn
 * first is visible, and the order of drawing depends on the order in which chunks arrived.
 */
const fewPixels = 4;
const titles = [/bucky/i, /marschner/i];
const names = ["bucky", "marschner_lobb"];
const versions = names.map((name) => join(demoFolder, `${name}.isosplat`));

test.use({ viewport: { width: 640, height: 420 } });

let folder: string;
let server: RunningServer;
/** Serves every version, without faults. */
let reference: RunningServer;
let host: Nginx;

test.beforeAll(async () => {
  folder = mkdtempSync(join(tmpdir(), "isosplat-chaos-"));
  put(0);
  server = await serve([folder]);
  reference = await serve(versions);
  host = await nginx({ folders: [folder] });
});
test.afterAll(async () => {
  await server.stop();
  await reference.stop();
  await host.stop();
  rmSync(folder, { recursive: true, force: true });
});

const store = (): string => join(folder, "chaos.isosplat");

/** Replaces the store by this version. */
function put(version: number, change: (bytes: Buffer) => Buffer = (bytes) => bytes): void {
  writeFileSync(`${store()}.part`, change(readFileSync(versions[version] ?? "")));
  renameSync(`${store()}.part`, store());
}

/** Like `put`, but also waits until the server has noticed the change. */
async function putAndServe(change?: (bytes: Buffer) => Buffer): Promise<void> {
  const status = async (): Promise<number> => (await fetch(`${server.url}v1/volumes/chaos`)).status;
  rmSync(store(), { force: true });
  await expect.poll(status).toBe(404);
  put(0, change);
  await expect.poll(status).not.toBe(404);
}

/** The version that the page shows. */
async function versionOf(page: Page): Promise<number> {
  const name = (await page.locator(".volume-name").textContent()) ?? "";
  const version = titles.findIndex((title) => title.test(name));
  expect(version, name).toBeGreaterThanOrEqual(0);
  return version;
}

async function slide(page: Page, share: number): Promise<void> {
  await page.evaluate((to) => {
    const slider = document.querySelector<HTMLInputElement>(".isovalue-slider");
    if (!slider) return;
    slider.valueAsNumber = Number(slider.min) + to * (Number(slider.max) - Number(slider.min));
    slider.dispatchEvent(new Event("input", { bubbles: true }));
  }, share);
}

/** Loses the context, and restores it after this time (ms). */
async function loseContext(page: Page, milliseconds: number): Promise<void> {
  await page.evaluate((wait) => {
    const gl = document.querySelector<HTMLCanvasElement>("canvas.view")?.getContext("webgl2");
    const extension = gl?.getExtension("WEBGL_lose_context");
    if (!extension || gl?.isContextLost()) return;
    extension.loseContext();
    setTimeout(() => extension.restoreContext(), wait);
  }, milliseconds);
}

/** One event of the store, the page, or its visitor. */
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

/** The picture of this view on a separate page without faults. */
async function undisturbed(browser: Browser, address: string): Promise<Buffer> {
  const context = await browser.newContext({ viewport: { width: 640, height: 420 } });
  const page = await context.newPage();
  await page.goto(address);
  await complete(page, 120_000);
  await settled(page, 120_000);
  const picture = await savedPicture(page);
  await context.close();
  return picture;
}

/** The page reports a complete picture without a message, and the picture is right. */
async function expectTruth(page: Page, browser: Browser, name: string): Promise<void> {
  const from = Date.now();
  // Coarse levels for other isovalues may be fetched afterwards.
  const timeout = longestRecovery;
  await expect(page.locator(".status-state")).toHaveText(/^complete(:| · |$)/, { timeout });
  const recovery = ((Date.now() - from) / 1000).toFixed(1);
  test.info().annotations.push({ type: "recovery", description: `${name}: ${recovery} s` });
  await settled(page, longestRecovery);
  await expect(page.getByRole("alert")).toHaveCount(0);
  await expect(page.locator(".banner")).toHaveCount(0);
  await expect(page.locator("wa-spinner")).toHaveCount(0);
  const view = new URL(page.url()).searchParams;
  for (const key of ["volume", "src"]) view.delete(key);
  const ours = await savedPicture(page);
  // The page may show either version. A version that became complete before the other one arrived
  // is valid.
  const volume = names[await versionOf(page)];
  const wanted = await undisturbed(browser, `${reference.url}?volume=${volume}&${view}`);
  const { differing, width, height } = await compare(page, ours, wanted);
  const pixels = Math.round(differing * width * height);
  if (pixels > 0) {
    for (const [file, body] of Object.entries({ ours, wanted })) {
      await test.info().attach(file, { body, contentType: "image/png" });
    }
  }
  expect(pixels, `${name}: pixels differ: ${page.url()}`).toBeLessThanOrEqual(fewPixels);
}

/** The page names the fault, and retries from time to time. */
async function expectCause(page: Page, fault: LastingFault, log: RequestLog): Promise<void> {
  const begun = Date.now();
  const isSoon = faults[fault.kind].retry === "soon";
  const message = page.locator("[role=alert], .banner").filter({ hasText: titleOf(fault) });
  await expect(message, fault.name).toHaveCount(1, { timeout: longestRecovery });
  // A spinner is shown only if the next try is soon.
  if (!isSoon) {
    await settled(page, longestRecovery);
    await expect(page.locator("wa-spinner")).toHaveCount(0);
  }
  if (fault.kind === "damaged-part") {
    const state = page.locator(".status-state");
    await expect(state).toHaveText(/^complete except for \d+ damaged parts?$/);
  } else {
    await expect(page.locator(".status-state")).not.toHaveText(/^complete/);
  }
  if (isSoon) await page.waitForTimeout(Math.max(0, begun + warmUp - Date.now()));
  log.clear();
  await page.waitForTimeout(watch);
  expect(log.closerThan(shortestGap), fault.name).toEqual([]);
  // The page must retry, to notice when the fault is repaired.
  expect(log.size, fault.name).toBeGreaterThan(0);
  await expect(message).toHaveCount(1);
}

/** No resources have leaked since the start. */
async function expectNoLeak({ page, before, heap }: Visit): Promise<void> {
  // Timers exist for short messages and for work prepared for the next frame.
  const isLess = async (): Promise<boolean> => {
    const { timers, listeners } = await holdingsOf(page);
    return timers <= before.timers && listeners <= before.listeners;
  };
  await expect.poll(isLess, { timeout: 30_000 }).toBe(true);
  const now = await holdingsOf(page);
  expect(now.workers).toBeLessThanOrEqual(before.workers);
  expect(now.contexts).toBe(before.contexts);
  // Programs are created on demand, and buffers with the samples.
  expect(now.glObjects).toBeLessThanOrEqual(2 * before.glObjects + 20);
  expect(await heapBytes(page)).toBeLessThan(1.5 * heap + 10e6);
}

type Where = "isosplat serve" | "nginx";

/** A page that shows the volume through a proxy, and its values at the start. */
interface Visit {
  page: Page;
  browser: Browser;
  proxy: FaultProxy;
  log: RequestLog;
  before: Holdings;
  heap: number;
}

async function randomFaults({ page, browser, proxy, log }: Visit, seed: number): Promise<void> {
  const chance = new Chance(seed);
  const share = 0.2 + 0.6 * chance.next();
  await test.step(`seed ${seed}: ${Math.round(100 * share)} % of the responses`, async () => {
    const ofRequests = new ChanceOfEach(seed);
    proxy.fault = (path) => {
      if (!isOfData(path)) return undefined;
      const ofThis = ofRequests.next(path);
      return ofThis.next() < share ? anyFault(ofThis) : undefined;
    };
    await page.getByRole("application").focus();
    for (let event = 0; event < eventsPerRound; ++event) {
      await happen(page, chance);
      await page.waitForTimeout(chance.whole(0, longestPause));
    }
    proxy.fault = () => undefined;
    await expectTruth(page, browser, `seed ${seed}`);
    // At rest, and with the coarse levels for other isovalues, there are no requests.
    await complete(page, longestRecovery);
    log.clear();
    await page.waitForTimeout(1500);
    expect(log.size).toBe(0);
  });
}

async function lastingFault(visit: Visit, fault: LastingFault, seed: number): Promise<void> {
  const { page, browser, proxy, log } = visit;
  await test.step(`seed ${seed}: ${fault.name}`, async () => {
    await fault.begin({ proxy, change: putAndServe });
    // Otherwise the caches of the page and the browser could replace the store.
    await log.clearCaches();
    if (fault.isForNewPage) await page.reload();
    else await loseContext(page, 100);
    await expectCause(page, fault, log);
    if (fault.kind === "unreachable") await proxy.start();
    proxy.fault = () => undefined;
    await putAndServe();
    await expectTruth(page, browser, `seed ${seed}, ${fault.name}`);
  });
}

/** Opens the page through a proxy, runs the rounds, and checks the page after each. */
async function visitThrough(
  where: Where,
  { page, browser }: { page: Page; browser: Browser },
  round: (visit: Visit, number: number) => Promise<void>,
): Promise<void> {
  test.setTimeout(1000 * seconds + 600_000);
  const proxy = new FaultProxy(where === "nginx" ? host.url : server.url);
  await proxy.start();
  const through =
    where === "nginx"
      ? `${server.url}?src=${encodeURIComponent(`${proxy.url}/chaos.isosplat`)}`
      : `${proxy.url}/?volume=chaos`;
  const thrown: string[] = [];
  page.on("pageerror", (error) => thrown.push(String(error)));
  await page.addInitScript(countHoldings);
  const log = await RequestLog.of(page);
  await putAndServe();
  try {
    // The drawn splats must not depend on the frame rate.
    await page.goto(`${through}&kind=ellipse`);
    await complete(page, 120_000);
    await settled(page, 120_000);
    const before = await holdingsOf(page);
    const visit = { page, browser, proxy, log, before, heap: await heapBytes(page) };
    const end = Date.now() + 1000 * seconds;
    for (let number = 0; number === 0 || Date.now() < end; ++number) {
      await round(visit, number);
      expect(thrown).toEqual([]);
      await expectNoLeak(visit);
      proxy.requests.length = 0;
    }
  } finally {
    await proxy.stop();
  }
}

for (const where of ["isosplat serve", "nginx"] as const) {
  const seedOf = (round: number): number => firstSeed + 1000 * round + (where === "nginx" ? 1 : 0);
  const faultOf = (round: number): LastingFault => {
    const possible = lastingFaults.filter((each) => each.where === "both" || where === "nginx");
    const fault = possible[(seedOf(0) + round) % possible.length];
    if (!fault) throw new Error("no fault");
    return fault;
  };

  if (seconds > 0) {
    test(`between the page and ${where}`, ({ page, browser }) =>
      visitThrough(where, { page, browser }, async (visit, round) => {
        await randomFaults(visit, seedOf(round));
        if (round % roundsToLasting > 0) return;
        await lastingFault(visit, faultOf(round / roundsToLasting), seedOf(round));
      }));
  } else {
    test(`random faults between the page and ${where}`, ({ page, browser }) =>
      visitThrough(where, { page, browser }, (visit) => randomFaults(visit, seedOf(0))));
    test(`a lasting fault between the page and ${where}`, ({ page, browser }) =>
      visitThrough(where, { page, browser }, (visit) =>
        lastingFault(visit, faultOf(0), seedOf(0)),
      ));
  }
}
