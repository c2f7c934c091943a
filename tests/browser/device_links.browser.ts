// Links to views of volumes on a device: what they contain, and what those see who open them elsewhere.
import { readFileSync } from "node:fs";
import { resolve } from "node:path";
import { type Browser, expect, type Page, test } from "@playwright/test";
import { drop } from "./support/drop.ts";
import { demoFolder, type RunningServer, serve } from "./support/server.ts";
import { complete, settled } from "./support/view.ts";

const file = resolve(demoFolder, "bucky.nrrd");
test.slow(); // two pages, one after the other
let server: RunningServer;
test.beforeAll(async () => {
  server = await serve([demoFolder]);
});
test.afterAll(() => server.stop());

/** Opens the file, changes the view, and copies its link. */
async function copiedLink(page: Page): Promise<string> {
  await page.context().grantPermissions(["clipboard-read", "clipboard-write"]);
  await page.goto(server.url);
  await expect(page.locator(".device-drop")).toBeVisible(); // what is dropped before is ignored
  await drop(page, [file]);
  await complete(page);
  await page.locator(".isovalue-slider").fill("140");
  await page.keyboard.press("c");
  await expect(page.locator(".toast")).toContainText(
    "Link copied. It has the view, not the volume",
  );
  await expect(page.locator(".toast")).toContainText("the same file (“bucky”)");
  return page.evaluate(() => navigator.clipboard.readText());
}

/** Opens a link in a browser that has none of the volumes. */
async function openElsewhere(browser: Browser, link: string): Promise<Page> {
  const context = await browser.newContext();
  const page = await context.newPage();
  await page.goto(link);
  return page;
}

test("the link of a volume on this device shows its view to who has the same file", async ({
  page,
  browser,
}) => {
  const link = await copiedLink(page);
  const { searchParams } = new URL(link);
  expect(searchParams.get("src")).toMatch(/^device:[0-9a-f]{32}$/);
  expect(searchParams.get("file")).toBe("bucky");
  expect(searchParams.get("isovalue")).toBe("140");

  const other = await openElsewhere(browser, link);
  await expect(other.locator(".device-expected")).toContainText("a view of “bucky”");
  await expect(other.locator(".device-expected")).toContainText("Drop or choose the same file");
  await drop(other, [file]);
  await complete(other);
  await expect(other.locator(".isovalue-slider")).toHaveValue("140");
  await settled(other);
  expect(new URL(other.url()).searchParams.get("isovalue")).toBe("140");
  await other.context().close();
});

test("another file than that of the link opens with its own view, and a message", async ({
  page,
  browser,
}) => {
  const link = await copiedLink(page);
  const other = await openElsewhere(browser, link);
  await expect(other.locator(".device-expected")).toBeVisible();
  await drop(other, [resolve(demoFolder, "mandelbulb.isosplat")]);
  await complete(other);
  await expect(other.locator(".task-card")).toContainText("not the volume of the link");
  await expect(other.locator(".isovalue-slider")).not.toHaveValue("140");
  await other.context().close();
});

test("the link of a kept volume that was fetched has the address it came from", async ({
  page,
}) => {
  await page.context().grantPermissions(["clipboard-read", "clipboard-write"]);
  const address = `${server.url}remote/bucky.nrrd`;
  const body = readFileSync(file);
  await page.route(address, (route) => route.fulfill({ body, headers: { ETag: '"1"' } }));
  await page.goto(`${server.url}?src=${encodeURIComponent(address)}`);
  await complete(page);
  await page.goto(server.url);
  await page.locator(".device-card a").click();
  await complete(page);
  expect(new URL(page.url()).searchParams.get("src")).toMatch(/^device:/);
  await page.keyboard.press("c");
  await expect(page.locator(".toast")).toContainText("Link copied");
  const link = new URL(await page.evaluate(() => navigator.clipboard.readText()));
  expect(link.searchParams.get("src")).toBe(address);
});

test("a scene of this device has no link", async ({ page }) => {
  await page.context().grantPermissions(["clipboard-read", "clipboard-write"]);
  const layers = [{ name: "bucky", store: "bucky.isosplat" }];
  const document = JSON.stringify({ format: "isosplat-scene", version: 1, layers });
  await page.goto(server.url);
  await page
    .locator(".device-drop input")
    .first()
    .setInputFiles([
      { name: "one.scene.json", mimeType: "application/json", buffer: Buffer.from(document) },
      {
        name: "bucky.isosplat",
        mimeType: "application/octet-stream",
        buffer: readFileSync(resolve(demoFolder, "bucky.isosplat")),
      },
    ]);
  await complete(page);
  await page.keyboard.press("c");
  await expect(page.locator(".toast")).toContainText("has no link");
});
