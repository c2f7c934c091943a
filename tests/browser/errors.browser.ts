// The page's messages when something is missing or invalid, and the actions that they offer.
import {
  copyFileSync,
  mkdtempSync,
  readFileSync,
  rmSync,
  truncateSync,
  writeFileSync,
} from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { expect, test } from "@playwright/test";
import { maxWholeBytes } from "../../web/stream/whole_file.ts";
import { nginx } from "../support/nginx.ts";
import { saveData, slideTo } from "./support/in_page.ts";
import { demoFolder, type RunningServer, serve } from "./support/server.ts";

import { complete } from "./support/view.ts";

const store = "bucky.isosplat";
let server: RunningServer;
test.beforeAll(async () => {
  server = await serve([demoFolder]);
});
test.afterAll(() => server.stop());
test.use({ viewport: { width: 800, height: 500 } });
// A store that was read as a whole would not show the faults of its source.
test.beforeEach(({ page }) => page.addInitScript(saveData));

test("the list of volumes fails, then loads", async ({ page }) => {
  let isGone = true;
  await page.route("**/v1/volumes", (route) => (isGone ? route.abort() : route.continue()));
  await page.goto(server.url);
  await expect(page.getByRole("alert")).toContainText("The server does not answer");
  isGone = false;
  await page.getByRole("button", { name: "Try again" }).click();
  await expect(page.getByRole("link", { name: /bucky/i })).toBeVisible();
  await expect(page.getByRole("alert")).toHaveCount(0);
});

test("an unknown volume: the message lists the existing volumes", async ({ page }) => {
  await page.goto(`${server.url}?volume=nothing-of-this-name`);
  const message = page.getByRole("alert");
  await expect(message).toContainText("No such volume");
  await expect(message).toContainText("nothing-of-this-name");
  await message.getByRole("link", { name: "bucky" }).click();
  await complete(page);
});

test("no WebGL 2", async ({ page }) => {
  await page.addInitScript(() => {
    HTMLCanvasElement.prototype.getContext = () => null;
  });
  await page.goto(`${server.url}?volume=bucky`);
  await expect(page.getByRole("alert")).toContainText("no WebGL 2");
  // There is no button for another attempt, because it could not succeed.
  await expect(page.getByRole("button", { name: "Try again" })).toHaveCount(0);
});

test("the server stops and is started again", async ({ page }) => {
  const own = await serve([demoFolder]);
  const port = Number(new URL(own.url).port);
  // The server stops twice: before the first picture, and during a later request.
  await page.goto(`${own.url}?volume=mandelbulb&isovalue=60`);
  await complete(page);
  await own.stop();
  await page.evaluate(slideTo, 200);
  await expect(page.locator(".banner")).toContainText("The server does not answer");
  const axes = await page.locator(".overlay-axes").boundingBox();
  const banner = await page.locator(".banner").boundingBox();
  expect(axes?.width).toBeGreaterThan(80);
  expect(banner?.x).toBeGreaterThan((axes?.x ?? 0) + (axes?.width ?? 0));
  await expect(page.locator(".status-samples")).toHaveText(/samples/);
  const again = await serve([demoFolder], port);
  try {
    await complete(page);
    await expect(page.locator(".banner")).toHaveCount(0);
  } finally {
    await again.stop();
  }
});

test("a store on a static host that answers Range, without any server", async ({ page }) => {
  const host = await nginx({ folders: ["build/page", demoFolder] });
  try {
    await page.goto(host.url);
    await expect(page.getByRole("alert")).toContainText("no list of volumes");
    await page.getByRole("textbox", { name: "Address of a store" }).fill(host.url + store);
    await page.getByRole("button", { name: "Open" }).click();
    await complete(page);
    await expect(page.locator(".volume-name")).toContainText(/bucky/i);
    await expect(page).toHaveURL(/src=http.*isovalue=/);
  } finally {
    await host.stop();
  }
});

test("a static host without Range: a small store is fetched whole, a large one is not", async ({
  page,
}) => {
  const folder = mkdtempSync(join(tmpdir(), "isosplat-no-range-"));
  const large = join(folder, "large.isosplat");
  copyFileSync(join(demoFolder, store), large);
  truncateSync(large, maxWholeBytes + 1);
  const host = await nginx({ folders: [demoFolder, folder], range: false });
  const open = (name: string) =>
    page.goto(`${server.url}?src=${encodeURIComponent(host.url + name)}`);
  try {
    await open(store);
    await complete(page);
    await open("large.isosplat");
    const message = page.getByRole("alert");
    await expect(message).toContainText("does not serve parts of files");
    await expect(message).toContainText("Range");
  } finally {
    await host.stop();
    rmSync(folder, { recursive: true, force: true });
  }
});

test("a file that is not a store, a missing file, and a damaged store", async ({ page }) => {
  const folder = mkdtempSync(join(tmpdir(), "isosplat-stores-"));
  writeFileSync(join(folder, "text.isosplat"), "This is not a store. ".repeat(5000));
  copyFileSync(join(demoFolder, store), join(folder, "good.isosplat"));
  const damaged = readFileSync(join(demoFolder, store));
  // All chunks of the file, but not its header.
  for (let i = 70_000; i < damaged.length; i += 1000) damaged[i] = (damaged[i] ?? 0) ^ 0x55;
  writeFileSync(join(folder, "damaged.isosplat"), damaged);
  const host = await nginx({ folders: [folder] });
  const open = (name: string) =>
    page.goto(`${server.url}?src=${encodeURIComponent(host.url + name)}`);
  try {
    await open("text.isosplat");
    await expect(page.getByRole("alert")).toContainText("not a store");
    await expect(page.getByRole("link", { name: "All volumes", exact: true })).toBeVisible();
    await open("missing.isosplat");
    await expect(page.getByRole("alert")).toContainText("No such volume");
    await open("damaged.isosplat");
    await expect(page.locator(".banner, [role=alert]").first()).toContainText("damaged");
    await open("good.isosplat");
    await complete(page);
  } finally {
    await host.stop();
    rmSync(folder, { recursive: true });
  }
});
