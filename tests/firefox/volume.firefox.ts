// A visit in Firefox, with the real server and a static host: a volume is opened, rotated,
// scrubbed, restored from its address, and compared with the native renderer's picture.
import { join } from "node:path";
import type { Page } from "puppeteer-core";
import { afterAll, afterEach, beforeAll, beforeEach, describe, expect, test } from "vitest";
import { rendererName } from "../browser/support/in_page.ts";
import { drawNatively } from "../browser/support/native_picture.ts";
import { type Comparison, comparePixels, decodePng } from "../browser/support/pixels.ts";
import { demoFolder, type RunningServer, serve } from "../browser/support/server.ts";
import { nginx } from "../support/nginx.ts";
import { type Firefox, startFirefox } from "./support/firefox.ts";
import { camera, complete, parameter, savedPicture, settled, shows } from "./support/view.ts";

const white = 0xffffff;

let firefox: Firefox;
let server: RunningServer;
let page: Page;
beforeAll(async () => {
  server = await serve([demoFolder]);
  firefox = await startFirefox();
});
afterAll(async () => {
  await firefox?.close();
  await server?.stop();
});
beforeEach(async () => {
  page = await firefox.browser.newPage();
  await page.setViewport({ width: 800, height: 500 });
});
afterEach(() => page.close());

/** Compares the first picture with the second, which is the reference. */
async function compared(ours: Buffer, theirs: Buffer): Promise<Comparison> {
  return comparePixels(await decodePng(page, ours), await decodePng(page, theirs), white);
}

async function canvasCentre(): Promise<{ x: number; y: number }> {
  const box = await (await page.waitForSelector("[role=application]"))?.boundingBox();
  if (!box) throw new Error("no canvas");
  return { x: box.x + box.width / 2, y: box.y + box.height / 2 };
}

test("lists the volumes, and opens one", async () => {
  await page.goto(server.url);
  await page.waitForFunction(() => document.querySelectorAll("a.card").length === 3);
  await shows(page, "a.card[href*=bucky]", /128 × 128 × 128/);
  // The page makes the card's picture of the surface automatically.
  await page.waitForSelector("a.card[href*=bucky] img", { visible: true });
  await page.locator("a.card[href*=bucky]").click();
  await shows(page, ".status-samples", /^[1-9].* samples$/);
  await complete(page);
  await shows(page, ".status-bytes", /fetched/);
  await shows(page, ".status-level", /full resolution|level/);
  expect(await page.evaluate(rendererName)).toContain("llvmpipe");
  expect(await parameter(page, "volume")).toBe("bucky");
  expect(await parameter(page, "isovalue")).toMatch(/^[\d.]+$/);
});

test("draws the native renderer's picture", async () => {
  const at = "40,25,330,63.5,63.5,63.5";
  const view = `isovalue=100.5&camera=${at}&kind=exact&background=ffffff`;
  await page.goto(`${server.url}?volume=bucky&${view}`);
  await complete(page);
  await settled(page);
  const ours = await savedPicture(firefox, page);
  const { width, height } = await decodePng(page, ours);
  const native = drawNatively(join(demoFolder, "bucky.isosplat"), {
    ...{ isovalue: 100.5, camera: at, kind: "exact", width, height },
  });
  const { covered, differing, stray, lost } = await compared(ours, native);
  expect(covered).toBeGreaterThan(0.1 * width * height);
  // Both draw with llvmpipe. No pixel differed when this test was written.
  expect(differing).toBeLessThan(0.001 * covered);
  expect(stray).toBe(0);
  expect(lost).toBe(0);
});

test("drag, wheel and keys change view and isovalue; the address restores them", async () => {
  await page.goto(`${server.url}?volume=bucky&isovalue=100&kind=exact&background=ffffff`);
  await complete(page);
  await settled(page);
  const first = await savedPicture(firefox, page);
  const { x, y } = await canvasCentre();

  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x + 60, y + 20, { steps: 3 });
  await page.mouse.up();
  const turned = await camera(page);
  expect(turned).toHaveLength(6);
  await page.mouse.wheel({ deltaY: -300 });
  const zoomed = await camera(page);
  expect(zoomed[2]).toBeLessThan(0.9 * (turned[2] ?? 0));
  expect(zoomed[0]).toBeCloseTo(turned[0] ?? 0, 3);
  await page.mouse.down({ button: "right" });
  await page.mouse.move(x + 50, y, { steps: 2 });
  await page.mouse.up({ button: "right" });
  expect((await camera(page)).slice(3)).not.toEqual(zoomed.slice(3));

  const slider = await page.waitForSelector(".isovalue-slider");
  await slider?.press("ArrowRight");
  await slider?.press("ArrowRight");
  expect(await parameter(page, "isovalue")).toBe("101");
  await complete(page);
  await settled(page);
  const moved = await savedPicture(firefox, page);
  const { covered, differing } = await compared(moved, first);
  expect(differing).toBeGreaterThan(0.1 * covered);

  const address = await page.evaluate(() => location.href);
  await page.reload();
  await complete(page);
  await settled(page);
  expect(await page.evaluate(() => location.href)).toBe(address);
  const restored = await compared(await savedPicture(firefox, page), moved);
  expect(restored.covered).toBeGreaterThan(0);
  expect(restored.differing).toBeLessThan(0.001 * restored.covered);
});

test("a notch of the wheel zooms equally in lines, pages and pixels", async () => {
  await page.goto(`${server.url}?volume=bucky&isovalue=100&camera=40,25,330,63.5,63.5,63.5`);
  await complete(page);
  const distances = [(await camera(page))[2] ?? 0];
  // Firefox sends lines or pages only for a real wheel; WebDriver's wheel sends pixels.
  for (const [deltaY, deltaMode] of [
    [-120, 0],
    [-3, 1],
    [-1, 2],
  ] as const) {
    await page.$eval(
      "[role=application]",
      (canvas, change) => canvas.dispatchEvent(new WheelEvent("wheel", change)),
      { deltaY, deltaMode },
    );
    distances.push((await camera(page))[2] ?? 0);
  }
  const factors = distances.slice(1).map((distance, i) => distance / (distances[i] ?? 0));
  expect(factors[0]).toBeLessThan(0.9);
  expect(factors[1]).toBeCloseTo(factors[0] ?? 0, 3);
  expect(factors[2]).toBeCloseTo(factors[0] ?? 0, 3);
});

test("a store on a static host, by ?src=", async () => {
  const host = await nginx({ folders: [demoFolder] });
  try {
    const store = encodeURIComponent(`${host.url}bucky.isosplat`);
    await page.goto(`${server.url}?src=${store}&isovalue=100&background=ffffff`);
    await complete(page);
    await settled(page);
    await shows(page, ".volume-name", /bucky/i);
    const picture = await savedPicture(firefox, page);
    const { covered } = await compared(picture, picture);
    const { width, height } = await decodePng(page, picture);
    // The whole volume is in view, with background around it.
    expect(covered).toBeGreaterThan(0.05 * width * height);
    expect(covered).toBeLessThan(0.95 * width * height);
    expect((await host.accessLog()).some((line) => line.includes(" 206 "))).toBe(true);
  } finally {
    await host.stop();
  }
});

describe("in a phone's window", () => {
  test("the controls are in a sheet, one finger rotates, two pinch", async () => {
    await page.setViewport({ width: 390, height: 844 });
    await page.goto(`${server.url}?volume=bucky&isovalue=100`);
    await complete(page);
    const wide = await page.evaluate(() => document.documentElement.scrollWidth);
    expect(wide).toBeLessThanOrEqual(390);
    await page.waitForSelector(".surface", { hidden: true });
    await page.locator("[aria-expanded=false]::-p-aria(More controls)").click();
    await page.waitForSelector(".surface", { visible: true });
    await page.keyboard.press("Escape");
    await page.waitForSelector(".surface", { hidden: true });

    const before = await camera(page);
    const finger = await page.touchscreen.touchStart(150, 300);
    await finger.move(190, 310);
    await finger.move(230, 320);
    await finger.end();
    const turned = await camera(page);
    expect(turned[0]).not.toBeCloseTo(before[0] ?? 0, 1);

    const [left, right] = [
      await page.touchscreen.touchStart(180, 300),
      await page.touchscreen.touchStart(210, 300),
    ];
    for (const by of [20, 40]) {
      await left.move(180 - by, 300);
      await right.move(210 + by, 300);
    }
    await left.end();
    await right.end();
    const pinched = await camera(page);
    expect(pinched[2]).toBeLessThan(0.6 * (turned[2] ?? 0));
    expect(pinched[0]).toBeCloseTo(turned[0] ?? 0, 3);
  });
});
