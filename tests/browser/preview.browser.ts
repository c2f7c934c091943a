// The reduced copy of a volume that is shown while its store is built.
import { closeSync, mkdtempSync, openSync, rmSync, truncateSync, writeSync } from "node:fs";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { expect, type Page, test } from "@playwright/test";
import { drop } from "./support/drop.ts";
import { demoFolder, type RunningServer, serve } from "./support/server.ts";
import { compare, complete, openSection, savedPicture, settled } from "./support/view.ts";

test.use({ viewport: { width: 800, height: 500 } });
test.setTimeout(180_000);

let server: RunningServer;
let folder: string;
let ball: string;

test.beforeAll(async () => {
  server = await serve([demoFolder]);
  folder = mkdtempSync(join(tmpdir(), "isosplat-preview-"));
  ball = join(folder, "ball.nrrd");
  writeNrrd(ball, [200, 180, 160], (x, y, z) => 255 - 2.2 * Math.hypot(x - 100, y - 90, z - 80));
});
test.afterAll(async () => {
  await server.stop();
  rmSync(folder, { recursive: true, force: true });
});

/** An NRRD file of bytes. Slices that are empty take no room on the disk. */
function writeNrrd(
  path: string,
  [x, y, z]: readonly [number, number, number],
  value: (x: number, y: number, z: number) => number,
  isEmpty = (_z: number) => false,
): void {
  const header =
    "NRRD0004\ntype: uint8\ndimension: 3\nencoding: raw\n" +
    `sizes: ${x} ${y} ${z}\nspacings: 1 1 ${Math.min(1, 200 / z)}\n\n`;
  const file = openSync(path, "w");
  writeSync(file, header);
  for (let k = 0; k < z; ++k) {
    if (isEmpty(k)) continue;
    const slice = new Uint8ClampedArray(x * y);
    for (let i = 0; i < slice.length; ++i) slice[i] = value(i % x, Math.floor(i / x), k);
    writeSync(file, slice, 0, slice.length, header.length + k * slice.length);
  }
  closeSync(file);
  truncateSync(path, header.length + x * y * z);
}

/**
 * Lets the first build wait for `release`, so that the page behaves as with a volume that takes
 * long to build.
 */
async function holdBuild(page: Page): Promise<{ release(): Promise<void> }> {
  await page.addInitScript(() => {
    let go = (): void => {};
    const released = new Promise<void>((resolve) => {
      go = resolve;
    });
    // The encoders of the volume are started first, those of its preview afterwards.
    let held = Math.min(8, navigator.hardwareConcurrency);
    const { postMessage } = Worker.prototype;
    Worker.prototype.postMessage = function (this: Worker, message, ...rest: []) {
      const isEncoder = typeof message === "object" && "port" in message;
      if (!isEncoder || held-- <= 0) postMessage.call(this, message, ...rest);
      else void released.then(() => postMessage.call(this, message, ...rest));
    };
    (globalThis as unknown as { release: () => void }).release = go;
  });
  return {
    release: () =>
      page.evaluate(() => (globalThis as unknown as { release: () => void }).release()),
  };
}

async function openStartPage(page: Page): Promise<void> {
  await page.goto(server.url);
  await expect(page.locator(".device-drop")).toBeVisible();
}

const preview = (page: Page) => page.locator(".provisional");
const card = (page: Page) => page.locator(".task-card");

async function previewed(page: Page): Promise<void> {
  await expect(preview(page)).toHaveText("Preview: 65 × 65 × 65 of 200 × 180 × 160 voxels");
  await complete(page);
  await settled(page);
}

async function built(page: Page): Promise<void> {
  await expect(card(page)).toHaveCount(0);
  await expect(preview(page)).toHaveCount(0);
  await complete(page);
  await settled(page);
}

test("a store replaces its preview, and the view stays", { tag: "@slow" }, async ({ page }) => {
  const build = await holdBuild(page);
  await openStartPage(page);
  await drop(page, [ball]);
  await previewed(page);
  await expect(card(page)).toContainText("Building ball");
  // The automatic kind depends on the time of frames.
  await openSection(page, "Appearance");
  await page.getByRole("combobox", { name: "Splats" }).click();
  await page.getByRole("option", { name: "Exact surface" }).click();
  await page.getByRole("application").focus();
  for (const key of ["]", "]", "]", "ArrowLeft", "ArrowUp"]) await page.keyboard.press(key);
  await settled(page);
  const view = new URL(page.url()).searchParams;
  expect(view.get("camera")).not.toBeNull();
  await build.release();
  await built(page);
  const after = new URL(page.url()).searchParams;
  expect(after.get("src")).not.toBe(view.get("src"));
  expect(after.get("isovalue")).toBe(view.get("isovalue"));
  expect(after.get("camera")).toBe(view.get("camera"));
  await expect(page.locator(".volume-facts")).toContainText("200 × 180 × 160");
  const replaced = await savedPicture(page);
  // Changes from before the store was complete can be undone.
  await page.keyboard.press("Control+z");
  await expect
    .poll(() => new URL(page.url()).searchParams.get("camera"))
    .not.toBe(after.get("camera"));
  await page.keyboard.press("Control+Shift+z");
  await expect.poll(() => new URL(page.url()).searchParams.get("camera")).toBe(after.get("camera"));
  await page.reload();
  await complete(page);
  await settled(page);
  const { differing, covered } = await compare(page, replaced, await savedPicture(page));
  expect(covered).toBeGreaterThan(0.05);
  expect(differing).toBe(0);
});

test("settings that the visitor has not chosen are those of the store", async ({ page }) => {
  const build = await holdBuild(page);
  await openStartPage(page);
  await drop(page, [ball]);
  await previewed(page);
  await build.release();
  await built(page);
  const replaced = new URL(page.url()).searchParams;
  expect(replaced.get("camera")).toBeNull();
  await page.goto(`${server.url}?src=${replaced.get("src")}`);
  await complete(page);
  await settled(page);
  expect(new URL(page.url()).searchParams.get("isovalue")).toBe(replaced.get("isovalue"));
});

test("cancelling returns to the previous content", { tag: "@slow" }, async ({ page }) => {
  await holdBuild(page);
  await openStartPage(page);
  await drop(page, [ball]);
  await previewed(page);
  await card(page).getByRole("button", { name: "Cancel" }).click();
  await expect(page.locator(".device-drop")).toBeVisible();
  await expect(page.locator(".device-card")).toHaveCount(0);
  expect(page.url()).toBe(server.url);

  await drop(page, [resolve(demoFolder, "bucky.isosplat")]);
  await complete(page);
  await settled(page);
  const before = page.url();
  await drop(page, [ball]);
  await page.getByRole("button", { name: "Open instead" }).click();
  await previewed(page);
  await card(page).getByRole("button", { name: "Cancel" }).click();
  // This store is in memory only.
  await expect(page.locator(".volume-name")).toHaveText("bucky");
  await complete(page);
  await settled(page);
  expect(page.url()).toBe(before);
});

test("of a volume that is too large, the preview stays beside the message", async ({ page }) => {
  const large = join(folder, "large.nrrd");
  const slices = 1 << 16;
  // The file contains the slices that are read for the preview; the others are holes.
  const read = new Set(Array.from({ length: 65 }, (_, i) => Math.round((i * (slices - 1)) / 64)));
  writeNrrd(
    large,
    [256, 256, slices],
    (x, y, z) => 255 - 2.2 * Math.hypot(x - 128, y - 128, z / 328 - 100),
    (z) => !read.has(z),
  );
  await openStartPage(page);
  await drop(page, [large]);
  const message = card(page).getByRole("alert");
  await expect(message).toContainText("isosplat build");
  await expect(preview(page)).toContainText(`of 256 × 256 × ${slices} voxels`);
  await complete(page);
  await card(page).getByRole("button", { name: "Close" }).click();
  await page.getByRole("application").focus();
  const isovalue = () => new URL(page.url()).searchParams.get("isovalue");
  await settled(page);
  const before = isovalue();
  await page.keyboard.press("]");
  await expect.poll(isovalue).not.toBe(before);
  await complete(page);
  await expect(preview(page)).toBeVisible();
});
