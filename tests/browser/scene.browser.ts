// Scenes in the page: a bundle by its address, and files of this device.
import { execFileSync } from "node:child_process";
import {
  copyFileSync,
  existsSync,
  mkdtempSync,
  readFileSync,
  rmSync,
  writeFileSync,
} from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { expect, test } from "@playwright/test";
import { type RangeHost, rangeHost } from "../support/range_host.ts";
import { ballIsovalue, buildBall } from "../support/series.ts";
import { program, type RunningServer, serve } from "./support/server.ts";
import { complete, settled } from "./support/view.ts";

const look = "kind=exact&shading=exact";
let folder: string;
let server: RunningServer;
let host: RangeHost;

const surfaces = (colour: string) => [{ isovalue: ballIsovalue, colour }];
const scene = {
  format: "isosplat-scene",
  version: 1,
  name: "Two balls",
  layers: [
    { name: "left", store: "left.isosplat", surfaces: surfaces("#c8553d") },
    { name: "right", store: "right.isosplat", surfaces: surfaces("#4f86c6"), group: "blue" },
    { name: "hidden", store: "hidden.isosplat", visible: false },
  ],
};

test.beforeAll(async () => {
  folder = mkdtempSync(join(tmpdir(), "isosplat-scene-"));
  for (const [name, x] of [
    ["left", 0.27],
    ["right", 0.73],
    ["hidden", 0.5],
  ] as const) {
    buildBall(folder, name, 72, { centre: [x, 0.5, 0.5], radius: 0.2 });
  }
  buildBall(folder, "small", 36, { centre: [0.5, 0.5, 0.5], radius: 0.2 });
  const missing = {
    ...scene,
    layers: [...scene.layers.slice(0, 1), { name: "lost", store: "lost.isosplat" }],
  };
  writeFileSync(join(folder, "two.scene.json"), JSON.stringify(scene));
  writeFileSync(join(folder, "missing.scene.json"), JSON.stringify(missing));
  const parts = scene.layers.map((layer) => ({
    ...layer,
    ...(layer.name !== "hidden" && { part_of: "Balls", surfaces: surfaces("#c8553d") }),
  }));
  // Its voxels lie elsewhere than those of the first part, as those of refinement levels do.
  const small = {
    store: "small.isosplat",
    part_of: "Balls",
    surfaces: surfaces("#c8553d"),
  };
  writeFileSync(
    join(folder, "parts.scene.json"),
    JSON.stringify({ ...scene, layers: [...parts, small] }),
  );
  writeFileSync(
    join(folder, "broken.scene.json"),
    `{"format":"isosplat-scene","version":1,"layers":[]}`,
  );
  execFileSync(program, [
    "bundle",
    join(folder, "two.scene.json"),
    "-o",
    join(folder, "two.isobundle"),
  ]);
  server = await serve([folder]);
  host = await rangeHost((path) => {
    const file = join(folder, path);
    return existsSync(file) ? readFileSync(file) : undefined;
  });
});
test.afterAll(async () => {
  host?.stop();
  await server?.stop();
  rmSync(folder, { recursive: true, force: true });
});

const names = ".layer-name";

test("a bundle at an address shows all its layers, with few requests", async ({ page }) => {
  host.asked.length = 0;
  await page.goto(`${server.url}?src=${host.origin}/two.isobundle&${look}`);
  await complete(page);
  await settled(page);
  await expect(page.locator(names)).toHaveText(["left", "right", "hidden"]);
  await expect(page).toHaveTitle("Two balls · Isosplat");
  const ranges = host.asked.filter((each) => each.startsWith("/two.isobundle bytes="));
  expect(ranges[0]).toBe("/two.isobundle bytes=0-65535");
  // The first range has all coarse parts of this bundle, which follow the header. The rest is read
  // by further ranges.
  expect(ranges.length).toBeLessThan(12);
  expect(new URL(page.url()).searchParams.get("src")).toBe(`${host.origin}/two.isobundle`);
  await expect(page.getByRole("alert")).toHaveCount(0);
});

test("parts of one volume are one layer of the list, and have one isovalue", async ({ page }) => {
  await page.goto(`${server.url}?src=${host.origin}/parts.scene.json&${look}`);
  await complete(page);
  await settled(page);
  await expect(page.locator(names)).toHaveText(["Balls", "hidden"]);
  await expect(page.locator(".layers-note")).toHaveCount(0);
  const field = page.getByRole("textbox", { name: "Isovalue" });
  const isovalue = String(ballIsovalue + 5);
  await field.fill(isovalue);
  await field.press("Enter");
  await complete(page);
  await settled(page);
  const { searchParams } = new URL(page.url());
  expect(searchParams.get("isovalue")).toBe(isovalue);
  // The second ball is a layer of its own in the address.
  expect(searchParams.getAll("layer").join()).toContain(`isovalue:${isovalue}`);
});

test("all layers of a large scene have a surface before finer levels are requested", async ({
  page,
}) => {
  const balls = Array.from({ length: 20 }, (_, i) => `ball${i}`);
  const layers = balls.map((name, i) => ({
    ...{ name, store: `${name}.isosplat`, surfaces: surfaces("#c8553d") },
    transform: [1, 0, 0, 80 * (i % 5), 0, 1, 0, 80 * Math.floor(i / 5), 0, 0, 1, 0, 0, 0, 0, 1],
  }));
  buildBall(folder, "ball0", 72, { centre: [0.5, 0.5, 0.5], radius: 0.4 });
  for (const name of balls.slice(1)) {
    copyFileSync(join(folder, "ball0.isosplat"), join(folder, `${name}.isosplat`));
  }
  const document = join(folder, "balls.scene.json");
  writeFileSync(document, JSON.stringify({ ...scene, layers }));
  execFileSync(program, ["bundle", document, "-o", join(folder, "balls.isobundle")]);
  await page.addInitScript(() => {
    const shown: number[] = [];
    Object.assign(window, { shown });
    new PerformanceObserver((list) => {
      for (const { startTime } of list.getEntriesByName("isosplat:surface")) shown.push(startTime);
    }).observe({ type: "mark" });
  });
  await page.goto(`${server.url}?src=${host.origin}/balls.isobundle&${look}`);
  await complete(page);
  const { shown, begun } = await page.evaluate(() => ({
    shown: (window as unknown as { shown: number[] }).shown,
    begun: performance
      .getEntriesByType("resource")
      .filter(({ name }) => name.endsWith("balls.isobundle"))
      .map(({ startTime }) => startTime),
  }));
  expect(shown.length).toBe(20);
  // Two for the header and all coarse parts. The first one has those of the first layers, which may go on.
  const last = Math.max(...shown);
  expect(begun.filter((time) => time < last).length).toBeLessThan(8);
  expect(begun.filter((time) => time > last).length).toBeGreaterThan(8);
});

test("the default view depends on the window, so a link does not have it", async ({ page }) => {
  await page.setViewportSize({ width: 390, height: 844 });
  await page.goto(`${server.url}?src=${host.origin}/two.isobundle&${look}`);
  await complete(page);
  await settled(page);
  expect(new URL(page.url()).searchParams.get("isovalue")).not.toBeNull();
  expect(new URL(page.url()).searchParams.get("camera")).toBeNull();
});

test("changes of a scene's layers are in the link", async ({ page }) => {
  await page.goto(`${server.url}?src=${host.origin}/two.isobundle&${look}`);
  await complete(page);
  await page
    .locator(".layer-row")
    .filter({ hasText: "right" })
    .getByRole("switch")
    .or(page.locator(".layer-row").filter({ hasText: "right" }).locator(".layer-eye"))
    .first()
    .click();
  await settled(page);
  expect(new URL(page.url()).searchParams.getAll("layer")).toEqual(["index:1;visible:off"]);
  const url = page.url();
  await page.goto("about:blank");
  await page.goto(url);
  await complete(page);
  await settled(page);
  expect(new URL(page.url()).searchParams.getAll("layer")).toEqual(["index:1;visible:off"]);
});

test("a document at an address shows the layers whose stores exist, and names the others", async ({
  page,
}) => {
  await page.goto(`${server.url}?src=${host.origin}/missing.scene.json&${look}`);
  await complete(page);
  await expect(page.getByText("Layer lost cannot be shown")).toBeVisible();
});

test("a scene that cannot be read is named with its fault", async ({ page }) => {
  await page.goto(`${server.url}?src=${host.origin}/broken.scene.json`);
  await expect(page.getByRole("alert").first()).toContainText(
    "layers: expected a list of 1 to 4096",
  );
});

test("a bundle of this device is opened, and nothing is uploaded", async ({ page }) => {
  await page.goto(server.url);
  await page.locator(".device-drop input").first().setInputFiles(join(folder, "two.isobundle"));
  await complete(page);
  await expect(page.locator(names)).toHaveText(["left", "right", "hidden"]);
});

test("a document of this device is opened with its stores", async ({ page }) => {
  await page.goto(server.url);
  await page
    .locator(".device-drop input")
    .first()
    .setInputFiles(
      ["two.scene.json", "left.isosplat", "right.isosplat", "hidden.isosplat"].map((file) =>
        join(folder, file),
      ),
    );
  await complete(page);
  await expect(page.locator(names)).toHaveText(["left", "right", "hidden"]);
});
