// Saving a volume of this device: as a store, as a single page, as a static site.
import { execFileSync } from "node:child_process";
import { copyFileSync, mkdtempSync, readFileSync, rmSync, statSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { type BrowserContext, expect, type Page, test } from "@playwright/test";
import { loadCore } from "../../web/core/index.ts";
import { hasNginx, nginx } from "../support/nginx.ts";
import { demoFolder, program, type RunningServer, serve } from "./support/server.ts";
import { complete } from "./support/view.ts";

const bucky = resolve(demoFolder, "bucky.isosplat");
let server: RunningServer;
let folder: string;
test.beforeAll(async () => {
  server = await serve([demoFolder]);
  folder = mkdtempSync(join(tmpdir(), "isosplat-save-"));
});
test.afterAll(async () => {
  await server.stop();
  rmSync(folder, { recursive: true, force: true });
});

/**
 * Opens a store or a bundle and saves it. Returns the file's path and the size that the page
 * predicted.
 */
async function save(page: Page, option: string, file: string, opened = bucky, view = "") {
  await page.goto(server.url + view);
  await page.locator(".device-drop input").first().setInputFiles(opened);
  await complete(page);
  await page.getByRole("button", { name: /^Save this (volume|scene as a page)$/ }).click();
  const section = page.locator(".save-option", { hasText: option });
  await expect(section.locator(".quiet").first()).toHaveText(/B$/);
  const predicted = await section.locator(".quiet").first().innerText();
  const download = page.waitForEvent("download");
  await section.getByRole("button").click();
  const path = join(folder, file);
  await (await download).saveAs(path);
  return { path, predicted };
}

/** Expects that a number with three digits and a decimal unit is about this many bytes. */
function expectAbout(predicted: string, bytes: number): void {
  const [number = "", unit = ""] = predicted.split(" ");
  const value = Number(number) * (unit === "MB" ? 1e6 : 1e3);
  expect(Math.abs(value - bytes) / bytes).toBeLessThan(0.02);
}

test("a store is saved unchanged", async ({ page }) => {
  const { path } = await save(page, "Store", "bucky.isosplat");
  expect(readFileSync(path).equals(readFileSync(bucky))).toBe(true);
});

/** Opens a saved page from file://. `requested`: the other files that it has requested. */
async function openAlone(context: BrowserContext, path: string) {
  const page = await context.newPage();
  const address = pathToFileURL(path).href;
  const requests: string[] = [];
  page.on("request", (request) => requests.push(request.url()));
  await page.goto(address);
  await complete(page);
  const requested = () => requests.filter((url) => url !== address && !/^(data|blob):/.test(url));
  return { page, requested };
}

test("a single page opens from file:// and makes no requests", async ({ page, context }) => {
  const { path, predicted } = await save(page, "Single page", "bucky.html");
  expectAbout(predicted, statSync(path).size);
  const { page: saved, requested } = await openAlone(context, path);
  await expect(saved.locator(".volume-name")).toHaveText("bucky");
  await saved.getByRole("button", { name: "Save the surface" }).click();
  const surface = saved.waitForEvent("download");
  await saved.getByRole("button", { name: "Save", exact: true }).click();
  expect((await surface).suggestedFilename()).toMatch(/^bucky-[\d.]+\.stl$/);
  expect(requested()).toEqual([]);
});

test("a single page has the view with which it was saved, and no link of a file", async ({
  page,
  context,
}) => {
  test.slow(); // two pages, one after the other
  const core = await loadCore();
  const store = core.openStore(readFileSync(bucky));
  const view =
    "isovalue=100,140&opacity=0.5,1&camera=20,10,250,63,63,63&clip=0,0.5,0,1,0,1&measure=distance,1,2,3,30,40,50";
  const link = `?src=device:${store.info.contentId}&${view}`;
  store.close();
  const { path } = await save(page, "Single page", "view.html", bucky, link);
  const { page: saved } = await openAlone(context, path);
  await expect(saved.locator(".surface")).toHaveCount(2);
  await expect(saved.locator(".isovalue-slider")).toHaveValue("100");
  await expect(saved.locator(".status-state")).toHaveText("complete: a part is clipped away");
  await expect(saved.locator(".measure-marks text")).toHaveCount(1);
  await saved.getByRole("button", { name: "Copy a link to this view" }).click();
  await expect(saved.locator(".toast")).toContainText("opened from a file has no link for others");
});

test("a bundle is saved as a single page, which shows the scene from file://", async ({
  page,
  context,
}) => {
  const scene = join(folder, "two.scene.json");
  const bundle = join(folder, "two.isobundle");
  const layer = (name: string) => ({ name, store: `${name}.isosplat` });
  const layers = [layer("bucky"), layer("mandelbulb")];
  writeFileSync(scene, JSON.stringify({ format: "isosplat-scene", version: 1, layers }));
  for (const { store } of layers) copyFileSync(resolve(demoFolder, store), join(folder, store));
  execFileSync(program, ["bundle", scene, "-o", bundle]);
  const { path, predicted } = await save(page, "Single page", "two.html", bundle);
  expectAbout(predicted, statSync(path).size);
  // There is no other option: the bundle is a file already, and a site has the store of one volume.
  await expect(page.locator(".save-option")).toHaveCount(1);
  const { page: saved, requested } = await openAlone(context, path);
  await expect(saved.locator(".layer-name")).toHaveText(["bucky", "mandelbulb"]);
  expect(requested()).toEqual([]);
});

test("a site is served by a plain host", async ({ page }) => {
  test.skip(!hasNginx, "needs nginx");
  const { path, predicted } = await save(page, "Web site", "bucky.zip");
  expectAbout(predicted, statSync(path).size);
  const site = join(folder, "site");
  const unpack = "import sys, zipfile; zipfile.ZipFile(sys.argv[1]).extractall(sys.argv[2])";
  execFileSync("/usr/bin/python3", ["-c", unpack, path, site]);
  const host = await nginx({ folders: [site], cors: "none" });
  try {
    await page.goto(host.url);
    const card = page.locator("a.card[data-name=bucky]");
    await expect(card).toContainText("128 × 128 × 128");
    await card.click();
    await complete(page);
    await expect(page).toHaveURL(/volume=bucky/);
    // This host sends .wasm with another type, as some do; the page still builds stores.
    await page.goto(host.url);
    await page
      .locator(".device-drop input")
      .first()
      .setInputFiles(resolve(demoFolder, "marschner_lobb.nrrd"));
    await complete(page);
    await expect(page).toHaveURL(/src=device%3A/);
  } finally {
    await host.stop();
  }
});
