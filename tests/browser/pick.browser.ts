// Clicks on surfaces: the page names the layer and the volume of its label; the element reports it.
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { expect, type Page, test } from "@playwright/test";
import type { IsosplatViewerElement } from "../../web/element/isosplat_viewer.ts";
import { ballIsovalue, buildBall } from "../support/series.ts";
import { findings } from "./support/accessibility.ts";
import { type HtmlHost, htmlHost } from "./support/html_host.ts";
import { type RunningServer, serve } from "./support/server.ts";
import { complete, settled } from "./support/view.ts";

const label = { value: 7, voxels: 185_293, volume: 1_482_345 };
let folder: string;
let server: RunningServer;
let pages: HtmlHost;

test.beforeAll(async () => {
  folder = mkdtempSync(join(tmpdir(), "isosplat-pick-"));
  buildBall(folder, "ball", 40, { centre: [0.5, 0.5, 0.5], radius: 0.3 });
  const ball = {
    store: "ball.isosplat",
    surfaces: [{ isovalue: ballIsovalue, colour: "#c8553d" }],
  };
  const scene = {
    format: "isosplat-scene",
    version: 1,
    name: "Organs",
    layers: [
      { ...ball, name: "liver", label },
      // The second label is inside of the first one, and half as large.
      {
        ...ball,
        name: "lesion",
        transform: [0.5, 0, 0, 9.75, 0, 0.5, 0, 9.75, 0, 0, 0.5, 9.75, 0, 0, 0, 1],
        label: { value: 8, voxels: 1, volume: 0.8 },
      },
      { ...ball, name: "skin", transform: [1, 0, 0, 100, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1] },
    ],
  };
  writeFileSync(join(folder, "organs.scene.json"), JSON.stringify(scene));
  const one = { ...scene, name: "One", layers: scene.layers.slice(0, 1) };
  writeFileSync(join(folder, "one.scene.json"), JSON.stringify(one));
  server = await serve([folder], 0, ["--cors", "*"]);
  pages = await htmlHost(
    () => `<!doctype html><script type="module" src="${server.url}isosplat-viewer.js"></script>
      <isosplat-viewer controls style="inline-size: 300px; block-size: 300px"
        scene="${server.url}v1/scenes/organs.scene" camera="30,20,200,19.5,19.5,19.5"></isosplat-viewer>`,
  );
});
test.afterAll(async () => {
  pages?.stop();
  await server?.stop();
  rmSync(folder, { recursive: true, force: true });
});

const look = "kind=exact&shading=exact&camera=30,20,200,19.5,19.5,19.5";
async function open(page: Page, query: string): Promise<void> {
  await page.goto(`${server.url}?${query}&${look}`);
  await complete(page);
  await settled(page);
  // The code for picks is loaded after the first surface.
  await page.waitForFunction(() => document.querySelector("link[href*=page_pick]") !== null);
}
const toast = (page: Page) => page.locator(".toast");
const picture = (page: Page) => page.getByRole("application");

test("a click names the label and its volume; a drag and a measurement do not", async ({
  page,
}) => {
  await open(page, "scene=organs.scene");
  await picture(page).click();
  await expect(toast(page)).toHaveText("liver · 1,482 cm³ · 185,293 voxels");
  await expect(toast(page)).toHaveAttribute("role", "status");
  expect(await findings(page)).toEqual([]);
  await expect(toast(page)).toHaveCount(0, { timeout: 15_000 });

  const box = await picture(page).boundingBox();
  const [x, y] = [(box?.x ?? 0) + (box?.width ?? 0) / 2, (box?.y ?? 0) + (box?.height ?? 0) / 2];
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x + 40, y);
  await page.mouse.move(x, y);
  await page.mouse.up();
  await page.keyboard.press("m");
  await page.getByRole("button", { name: "End measuring" }).waitFor();
  await picture(page).click();
  await expect(toast(page)).toHaveCount(0);
  await page.keyboard.press("Escape");

  // The visible layer is named, and its volume takes the transform into account.
  await page.getByRole("button", { name: "Show liver" }).click();
  await complete(page);
  await page.keyboard.press("i");
  await expect(toast(page)).toHaveText("lesion · 0.1 mm³ · 1 voxel");
  // A click beside the surfaces shows no message.
  await picture(page).click({ position: { x: 5, y: 150 } });
  await expect(toast(page)).toHaveText("lesion · 0.1 mm³ · 1 voxel");
});

test("in German, and of a scene with one layer", async ({ page }) => {
  await page.goto(`${server.url}?scene=one.scene&lang=de&${look}`);
  await expect(page.locator(".status-state")).toHaveText(/^vollständig/);
  await page.waitForFunction(() => document.querySelector("link[href*=page_pick]") !== null);
  await page.keyboard.press("i");
  await expect(toast(page)).toHaveText("liver · 1.482 cm³ · 185.293 Voxel");
});

test("a single volume has no name to show", async ({ page }) => {
  await open(page, `volume=ball&isovalue=${ballIsovalue}`);
  await picture(page).click();
  await page.keyboard.press("i");
  await expect(toast(page)).toHaveText(
    "There is no layer with a name in the middle of the picture.",
  );
});

test("the element reports the layer and its label", async ({ page }) => {
  await page.goto(pages.origin);
  const element = page.locator("isosplat-viewer");
  await expect
    .poll(() => element.evaluate((e: IsosplatViewerElement) => e.progress?.complete))
    .toBe(true);
  const picks = await element.evaluateHandle((e: IsosplatViewerElement) => {
    const seen: unknown[] = [];
    e.addEventListener("pick", ({ detail }) => seen.push(detail));
    return seen;
  });
  await element.getByRole("application").click({ position: { x: 150, y: 150 } });
  await element.getByRole("application").press("Enter");
  // A click on the controls, which are parts of the element, is not a pick.
  await element.getByRole("button", { name: "Fit" }).click();
  const seen = await picks.jsonValue();
  expect(seen).toHaveLength(2);
  for (const each of seen) {
    expect(each).toMatchObject({
      name: "liver",
      label,
      isovalue: ballIsovalue,
      layer: expect.any(Number),
      position: [expect.any(Number), expect.any(Number), expect.any(Number)],
    });
  }
});
