// The page's messages and recovery in Firefox after faults of a file, the server or the graphics
// driver.
import {
  copyFileSync,
  mkdtempSync,
  readdirSync,
  readFileSync,
  renameSync,
  rmSync,
  symlinkSync,
  writeFileSync,
} from "node:fs";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import type { Page } from "puppeteer-core";
import { afterAll, afterEach, beforeAll, beforeEach, expect, test } from "vitest";
import { damagedChunks } from "../browser/support/damage.ts";
import { loseContext, restoreContext, saveData, slideTo } from "../browser/support/in_page.ts";
import { comparePixels, decodePng } from "../browser/support/pixels.ts";
import { demoFolder, type RunningServer, serve } from "../browser/support/server.ts";
import { nginx } from "../support/nginx.ts";
import { type Firefox, startFirefox } from "./support/firefox.ts";
import { complete, savedPicture, saysNothing, settled, shows } from "./support/view.ts";

let firefox: Firefox;
let server: RunningServer;
let folder: string;
let page: Page;
beforeAll(async () => {
  folder = mkdtempSync(join(tmpdir(), "isosplat-firefox-"));
  const bucky = readFileSync(join(demoFolder, "bucky.isosplat"));
  writeFileSync(join(folder, "damaged.isosplat"), damagedChunks(bucky, 24));
  for (const store of readdirSync(demoFolder).filter((name) => name.endsWith(".isosplat"))) {
    symlinkSync(resolve(demoFolder, store), join(folder, store));
  }
  server = await serve([folder]);
  firefox = await startFirefox();
});
afterAll(async () => {
  await firefox?.close();
  await server?.stop();
  rmSync(folder, { recursive: true, force: true });
});
beforeEach(async () => {
  page = await firefox.browser.newPage();
  await page.setViewport({ width: 800, height: 500 });
  // A store that was read as a whole would not show the faults of its source.
  await page.evaluateOnNewDocument(saveData);
});
afterEach(() => page.close());

test("an unknown volume: the message lists the existing volumes", async () => {
  await page.goto(`${server.url}?volume=nothing-of-this-name`);
  await shows(page, "[role=alert]", /No such volume/);
  await shows(page, "[role=alert]", /nothing-of-this-name/);
  await page.locator("[role=alert] a[href*=bucky]").click();
  await complete(page);
});

test("no store at the address, and a host that does not respond", async () => {
  const host = await nginx({ folders: [folder] });
  const address = `${server.url}?src=${encodeURIComponent(`${host.url}missing.isosplat`)}`;
  try {
    await page.goto(address);
    await shows(page, "[role=alert]", /No such volume/);
  } finally {
    await host.stop();
  }
  await page.goto(address);
  await shows(page, "[role=alert]", /does not answer/);
});

test("the server stops and is started again", async () => {
  const own = await serve([demoFolder]);
  const port = Number(new URL(own.url).port);
  await page.goto(`${own.url}?volume=mandelbulb&isovalue=60`);
  await complete(page);
  await own.stop();
  await page.evaluate(slideTo, 200);
  await shows(page, ".banner", /The server does not answer/);
  await shows(page, ".status-samples", /samples/);
  const again = await serve([demoFolder], port);
  try {
    await complete(page);
    await saysNothing(page);
  } finally {
    await again.stop();
  }
});

test("a store that is replaced under its name: the page opens the new one", async () => {
  const address = `${server.url}v1/volumes/replaced`;
  const entry = async (): Promise<string> => JSON.stringify(await (await fetch(address)).json());
  /** Resolves when the server has noticed the change. */
  const put = async (name: string): Promise<void> => {
    const store = join(folder, "replaced.isosplat");
    copyFileSync(join(demoFolder, `${name}.isosplat`), `${store}.part`);
    renameSync(`${store}.part`, store);
    const wanted = await (await fetch(`${server.url}v1/volumes/${name}`)).json();
    await expect.poll(entry, { timeout: 20_000 }).toContain(wanted.contentId);
  };
  await put("marschner_lobb");
  await page.goto(`${server.url}?volume=replaced&isovalue=60`);
  await complete(page);
  await put("mandelbulb");
  await page.evaluate(slideTo, 200);
  await shows(page, ".volume-name", /mandelbulb/i);
  await complete(page);
  await saysNothing(page);
});

test("damaged chunks: everything else is complete", async () => {
  await page.goto(`${server.url}?volume=damaged&isovalue=128&camera=30,20,300,64,64,64`);
  await shows(page, ".status-state", /^complete except for \d+ damaged parts?$/);
  await shows(page, ".banner", /The store is damaged/);
  await settled(page);
  await shows(page, ".status-samples", /^[1-9].* samples$/);
});

test("the graphics context is lost and restored: the same picture, and no message", async () => {
  await page.goto(`${server.url}?volume=bucky&isovalue=100&kind=exact&background=ffffff`);
  await complete(page);
  await settled(page);
  const before = await decodePng(page, await savedPicture(firefox, page));
  for (let round = 0; round < 2; ++round) {
    await page.evaluate(loseContext);
    await shows(page, ".banner", /took the graphics card away/);
    await page.evaluate(restoreContext);
    await complete(page);
    await settled(page);
    await saysNothing(page);
  }
  const after = await decodePng(page, await savedPicture(firefox, page));
  const { covered, differing } = comparePixels(after, before, 0xffffff);
  expect(covered).toBeGreaterThan(0.05 * before.width * before.height);
  expect(differing).toBe(0);
});
