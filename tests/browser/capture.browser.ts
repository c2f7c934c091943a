// Pictures of any size, in the real page.
import { readFileSync } from "node:fs";
import { resolve } from "node:path";
import { expect, type Locator, type Page, test } from "@playwright/test";
import { drawNatively } from "./support/native_picture.ts";
import { demoFolder, type RunningServer, serve } from "./support/server.ts";
import { compare, complete, savedPicture, settled } from "./support/view.ts";

let server: RunningServer;
test.beforeAll(async () => {
  server = await serve([demoFolder]);
});
test.afterAll(() => server.stop());

const camera = "40,25,330,63.5,63.5,63.5";

/** Opens a volume, and the dialog. */
async function openDialog(page: Page, view = camera): Promise<void> {
  await page.goto(
    `${server.url}?volume=bucky&isovalue=100&camera=${view}&kind=exact&background=ffffff`,
  );
  await complete(page);
  await settled(page);
  await page.getByRole("application").focus();
  await page.keyboard.press("Shift+S");
  await expect(page.getByRole("dialog", { name: "Save a picture of any size" })).toBeVisible();
}

function status(page: Page): Locator {
  return page.locator(".capture-form [role=status]");
}

async function chooseSize(page: Page, width: number, height: number): Promise<void> {
  await page.getByLabel("Size in pixels").selectOption("own");
  await page.getByLabel("Width", { exact: true }).fill(String(width));
  await page.getByLabel("Height", { exact: true }).fill(String(height));
}

async function save(page: Page): Promise<Buffer> {
  const [download] = await Promise.all([
    page.waitForEvent("download", { timeout: 150_000 }),
    page.getByRole("button", { name: "Save", exact: true }).click(),
  ]);
  return readFileSync(await download.path());
}

test("a picture wider than its parts is that of the program", async ({ page }) => {
  test.setTimeout(180_000);
  const [width, height] = [1150, 190];
  await openDialog(page);
  await chooseSize(page, width, height);
  const png = await save(page);
  const view = { isovalue: 100, camera, kind: "exact", width, height } as const;
  const native = drawNatively(resolve(demoFolder, "bucky.isosplat"), view);
  const found = await compare(page, png, native);
  expect([found.width, found.height]).toEqual([width, height]);
  expect(found.covered).toBeGreaterThan(0.02);
  expect(found.differing).toBeLessThan(0.001);
});

test("a picture can be cancelled, and the view stays as it was", async ({ page }) => {
  test.setTimeout(180_000);
  await page.setViewportSize({ width: 420, height: 400 });
  await openDialog(page, "40,25,2500,63.5,63.5,63.5"); // most of the picture is background
  await page.keyboard.press("Escape");
  await settled(page);
  const before = await savedPicture(page);
  await settled(page);
  await page.getByRole("application").focus();
  await page.keyboard.press("Shift+S");
  await chooseSize(page, 16385, 16384);
  await expect(status(page)).toContainText("from 1 to 16384");
  await chooseSize(page, 6000, 6000);
  await page.getByRole("button", { name: "Save", exact: true }).click();
  await expect(status(page)).toHaveText(/Drawing/, {
    timeout: 60_000,
  });
  // In one task: each part blocks the page, and a pointer's click takes several.
  const cancel = page.locator(".capture-actions wa-button", { hasText: "Cancel" });
  await cancel.evaluate((button: HTMLElement) => button.click());
  await expect(status(page)).toHaveText("Cancelled", {
    timeout: 60_000,
  });
  await page.keyboard.press("Escape");
  await settled(page);
  const after = await savedPicture(page);
  expect((await compare(page, before, after)).differing).toBeLessThan(0.001);
});

test("a picture without background is transparent", async ({ page }) => {
  test.setTimeout(120_000);
  await openDialog(page);
  await chooseSize(page, 120, 90);
  await page.getByLabel("Without background").check();
  const png = await save(page);
  // IHDR: width, height, 8 bits, RGBA.
  expect([png.readUInt32BE(16), png.readUInt32BE(20), png[24], png[25]]).toEqual([120, 90, 8, 6]);
  const corner = await page.evaluate(async (base64) => {
    const bytes = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
    const bitmap = await createImageBitmap(new Blob([bytes], { type: "image/png" }));
    const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext("2d");
    context?.drawImage(bitmap, 0, 0);
    const alpha = (x: number, y: number) => context?.getImageData(x, y, 1, 1).data[3];
    return [alpha(0, 0), alpha(60, 20)];
  }, png.toString("base64"));
  expect(corner[0]).toBe(0);
  await expect(status(page)).toContainText("Saved");
});
