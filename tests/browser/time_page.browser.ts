// The page of a scene that changes with time: its bar, keys, address, undo and films.
import { execFileSync } from "node:child_process";
import { copyFileSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { expect, type Page, test } from "@playwright/test";
import { type Nginx, nginx } from "../support/nginx.ts";
import { ballIsovalue, buildBall } from "../support/series.ts";
import { findings } from "./support/accessibility.ts";
import { program, type RunningServer, serve } from "./support/server.ts";
import { complete, settled } from "./support/view.ts";

const values = [0, 0.5, 1, 2, 4, 8];

let folder: string;
let server: RunningServer;
let host: Nginx;
test.beforeAll(async () => {
  folder = mkdtempSync(join(tmpdir(), "isosplat-time-page-"));
  for (const step of values.keys()) {
    const ball = { centre: [0.25 + 0.1 * step, 0.5, 0.3] as const, radius: 0.18 };
    buildBall(folder, `moves${step}`, 72, ball);
  }
  buildBall(folder, "stays", 72, { centre: [0.5, 0.5, 0.75], radius: 0.18 });
  const surfaces = (colour: string) => [{ isovalue: ballIsovalue, colour }];
  const scene = {
    format: "isosplat-scene",
    version: 1,
    name: "Run",
    time: { steps: values, unit: "ms" },
    layers: [
      {
        name: "moves",
        stores: values.map((_, step) => `moves${step}.isosplat`),
        surfaces: surfaces("#c8553d"),
      },
      { name: "stays", store: "stays.isosplat", surfaces: surfaces("#4f86c6") },
    ],
  };
  const file = join(folder, "scene.json");
  writeFileSync(file, JSON.stringify(scene));
  execFileSync(program, ["bundle", file, "-o", join(folder, "run.isobundle")]);
  server = await serve([folder]);
  host = await nginx({ folders: [folder] });
});
test.afterAll(async () => {
  await host?.stop();
  await server?.stop();
  rmSync(folder, { recursive: true, force: true });
});

async function open(page: Page, more = "", file = "run.isobundle"): Promise<void> {
  await page.goto(`${server.url}?src=${host.url}${file}&kind=exact&shading=exact${more}`);
  await expect(page.locator(".time-bar")).toBeVisible();
  if (!more.includes("lang=de")) await complete(page);
  await settled(page);
}
const value = (page: Page) => page.locator(".time-value");
const timeOf = (page: Page) => new URL(page.url()).searchParams.get("time");

test("the bundle that isosplat build makes from files is shown with their times", async ({
  page,
}) => {
  const files = [3, 20, 100].map((time, i) => {
    const file = join(folder, `part_${time}.nrrd`);
    copyFileSync(join(folder, `moves${i}.nrrd`), file);
    return file;
  });
  const output = join(folder, "built.isobundle");
  execFileSync(program, ["build", ...files, "-o", output, "--time-unit", "s", "--quiet"]);
  await open(page, "", "built.isobundle");
  await expect(value(page)).toHaveText("3 s");
  await page.getByRole("application").focus();
  await page.keyboard.press(".");
  await page.keyboard.press(".");
  await expect(value(page)).toHaveText("100 s");
  await settled(page);
  expect(timeOf(page)).toBe("100");
  await expect(page.getByRole("alert")).toHaveCount(0);
});

test("keys, slider, address and undo agree on the step", async ({ page }) => {
  await open(page);
  await expect(value(page)).toHaveText("0 ms");
  await expect(page.locator(".time-cost")).toHaveText(
    /^6 steps, (about )?[\d.]+ KB at full detail$/,
  );
  expect(timeOf(page)).toBeNull();
  await page.getByRole("application").focus();
  await page.keyboard.press(".");
  await page.keyboard.press(".");
  await expect(value(page)).toHaveText("1 ms");
  await settled(page);
  expect(timeOf(page)).toBe("1");
  await page.keyboard.press(",");
  await settled(page);
  expect(timeOf(page)).toBe("0.5");
  const slider = page.getByRole("slider", { name: "Time" });
  await slider.focus();
  await page.keyboard.press("End");
  await settled(page);
  await expect(slider).toHaveAttribute("aria-valuetext", "8 ms, step 6 of 6");
  expect(timeOf(page)).toBe("8");
  // The first step follows the last one.
  await page.keyboard.press(".");
  await settled(page);
  await expect(value(page)).toHaveText("0 ms");
  await page.keyboard.press("Control+z");
  await settled(page);
  await expect(value(page)).toHaveText("8 ms");
  expect(timeOf(page)).toBe("8");
  await page.reload();
  await complete(page);
  await settled(page);
  await expect(value(page)).toHaveText("8 ms");
});

test("plays, loops without further requests, and stays at the paused step", async ({ page }) => {
  await open(page);
  await page.getByLabel("Steps per second").selectOption({ label: "10 per second" });
  await page.getByRole("button", { name: "Play (K)" }).click();
  const shown = new Set<string>();
  await expect(async () => {
    shown.add(await value(page).innerText());
    expect(shown.size).toBe(values.length);
  }).toPass({ intervals: [30], timeout: 30_000 });
  await expect(async () => {
    const before = (await host.accessLog()).length;
    await page.waitForTimeout(1500);
    expect((await host.accessLog()).length).toBe(before);
  }).toPass({ timeout: 20_000 });
  await page.getByRole("button", { name: "Pause (K)" }).click();
  await settled(page);
  const paused = await value(page).innerText();
  await page.waitForTimeout(400);
  await expect(value(page)).toHaveText(paused);
  expect(`${timeOf(page) ?? "0"} ms`).toBe(paused);
});

test("a link opens its step alone; a document with its stores plays as well", async ({ page }) => {
  await open(page, "&time=2.1", "scene.json");
  await expect(value(page)).toHaveText("2 ms");
  const log = (await host.accessLog()).join("\n");
  expect(log).toContain("moves3.isosplat");
  // The first steps are not fetched. Two steps are fetched in advance.
  expect(log).not.toMatch(/moves[012]\.isosplat/);
  await page.getByRole("application").focus();
  await page.keyboard.press("k");
  await expect(value(page)).toHaveText("8 ms", { timeout: 20_000 });
  await page.keyboard.press("k");
});

test("on a phone and in German, all controls can be reached and named", async ({ page }) => {
  await page.setViewportSize({ width: 360, height: 700 });
  await open(page, "&lang=de&time=4");
  await expect(value(page)).toHaveText("4 ms");
  await expect(page.locator(".time-step")).toHaveText("Schritt 5 von 6");
  for (const name of ["Einen Schritt zurück (,)", "Abspielen (K)", "Einen Schritt vor (.)"]) {
    await expect(page.getByRole("button", { name })).toBeInViewport({ ratio: 1 });
  }
  await expect(page.locator(".time-cost")).toBeInViewport({ ratio: 1 });
  const bar = await page.locator(".time-bar").boundingBox();
  const picture = await page.getByRole("application").boundingBox();
  expect(picture?.height).toBeGreaterThan(200);
  expect((picture?.y ?? 0) + (picture?.height ?? 0)).toBeLessThanOrEqual((bar?.y ?? 0) + 1);
  expect(await findings(page)).toEqual([]);
});

test("a film through time shows each step", { tag: "@slow" }, async ({ page }) => {
  test.setTimeout(120_000);
  await page.setViewportSize({ width: 420, height: 400 });
  await open(page, "&time=4");
  await page.getByRole("application").focus();
  await page.keyboard.press("Shift+S");
  await page.getByLabel("What").selectOption({ label: "Film: through time" });
  await page.getByLabel("Size in pixels").selectOption({ label: "Other …" });
  await page.getByLabel("Width").fill("64");
  await page.getByLabel("Height").fill("48");
  await page.getByLabel("Seconds").fill("0.5");
  await page.getByLabel("Frames per second").selectOption("24");
  await page.getByLabel("File").selectOption({ label: "PNG files in a ZIP" });
  const [download] = await Promise.all([
    page.waitForEvent("download", { timeout: 90_000 }),
    page.getByRole("button", { name: "Save", exact: true }).click(),
  ]);
  const frames = entriesOf(readFileSync(await download.path()));
  expect(frames.length).toBe(12);
  // Twelve frames of six steps: two of each.
  expect(new Set(frames).size).toBe(values.length);
  for (let i = 0; i < frames.length; i += 2) expect(frames[i]).toBe(frames[i + 1]);
  await page.keyboard.press("Escape");
  await settled(page);
  await expect(value(page)).toHaveText("4 ms");
});

/** The checksums of the files of a ZIP, from its directory. */
function entriesOf(zip: Buffer): number[] {
  const sums: number[] = [];
  for (let at = zip.indexOf("PK\x01\x02"); at >= 0; at = zip.indexOf("PK\x01\x02", at + 4)) {
    sums.push(zip.readUInt32LE(at + 16));
  }
  return sums;
}
