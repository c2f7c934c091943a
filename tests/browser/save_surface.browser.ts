// The dialog that saves the surface of the page as triangles.
import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { expect, type Page, test } from "@playwright/test";
import { findings } from "./support/accessibility.ts";
import { saveData } from "./support/in_page.ts";
import { demoFolder, program, type RunningServer, serve } from "./support/server.ts";
import { complete, settled } from "./support/view.ts";

let server: RunningServer;
let folder: string;
test.beforeAll(async () => {
  folder = mkdtempSync(join(tmpdir(), "isosplat-surface-"));
  server = await serve([demoFolder]);
});
test.afterAll(async () => {
  await server.stop();
  rmSync(folder, { recursive: true, force: true });
});

/** A cube in a raw file, which states no spacing. */
function buildUnspaced(path: string): void {
  const size = 128;
  const voxels = new Uint8Array(size ** 3);
  for (let z = 32; z < 96; ++z) {
    for (let y = 32; y < 96; ++y)
      voxels.fill(200, (z * size + y) * size + 32, (z * size + y) * size + 96);
  }
  writeFileSync(`${path}.raw`, voxels);
  const layout = ["--dims", "128x128x128", "--type", "u8"];
  execFileSync(program, [
    "build",
    `${path}.raw`,
    "-q",
    "--no-thumbnail",
    ...layout,
    "-o",
    `${path}.isosplat`,
  ]);
}

/** The triangles of an STL file: all but its comment. */
const triangles = (path: string) => readFileSync(path).subarray(80);

function extracted(...more: string[]): Buffer {
  const path = join(folder, "native.stl");
  const store = join(demoFolder, "bucky.isosplat");
  const args = ["extract", store, "-i", "100", "--mesh", "-o", path, "--force", ...more];
  execFileSync(program, args);
  return triangles(path);
}

async function openDialog(page: Page, view = ""): Promise<void> {
  await page.goto(`${server.url}?volume=bucky&isovalue=100${view}`);
  await complete(page);
  await settled(page);
  await page.getByRole("button", { name: "Save the surface" }).click();
  await expect(page.getByRole("status").getByText("triangles")).toHaveText(
    /bout [\d.]+ k triangles, [\d.]+ MB\. Reads [\d.]+ KB, and computes for about/,
  );
}

const saveButton = (page: Page) => page.getByRole("button", { name: "Save", exact: true });

async function save(page: Page): Promise<Buffer> {
  const download = page.waitForEvent("download");
  await saveButton(page).click();
  const path = join(folder, "page.stl");
  const file = await download;
  expect(file.suggestedFilename()).toBe("bucky-100.stl");
  await file.saveAs(path);
  await expect(page.getByText(/^Saved: /)).toBeVisible();
  return triangles(path);
}

test("saves the triangles that the program extracts", async ({ page }) => {
  await openDialog(page);
  expect(await findings(page)).toEqual([]);
  expect((await save(page)).equals(extracted())).toBe(true);
  await page.getByLabel("Detail").selectOption("1");
  await expect(page.getByText(/^At most about/)).toBeVisible();
  expect((await save(page)).equals(extracted("--level", "1"))).toBe(true);
});

test("saves the part in the clipping box, or the whole surface on request", async ({ page }) => {
  await openDialog(page, "&clip=0,0.5,0,1,0,1");
  // Half of the 127 cells along x: the cells whose centres are below 63.5.
  expect((await save(page)).equals(extracted("--box", "-1,-1,-1,63.5,200,200"))).toBe(true);
  await page.getByLabel("Only what is inside").uncheck();
  await expect(page.getByText(/^About [\d.]+ k/)).toBeVisible();
  expect((await save(page)).equals(extracted())).toBe(true);
});

test("closes the surface where oblique planes cut it, or says that an open one is not cut", async ({
  page,
}) => {
  await openDialog(page, "&plane=1,1,0,120");
  await expect(page.getByLabel("Closed")).toBeChecked();
  await expect(page.getByText("in millimetres")).toBeVisible();
  const cut = await save(page);
  expect(cut.equals(extracted("--clip-plane", "1,1,0,120"))).toBe(true);
  await page.getByLabel("Closed").uncheck();
  await expect(page.getByText("planes, which cut only a closed surface")).toBeVisible();
  await expect(page.getByText(/bout [\d.]+ k triangles/)).toBeVisible();
  expect((await save(page)).equals(extracted("--open"))).toBe(true);
  expect(await findings(page)).toEqual([]);
});

/** Holds all requests for `address` back until the returned function is called. */
async function hold(page: Page, address: RegExp): Promise<() => void> {
  let release = () => {};
  const held = new Promise<void>((resolve) => {
    release = resolve;
  });
  await page.route(address, async (route) => {
    await held;
    await route.continue().catch(() => {});
  });
  return release;
}

test("can be cancelled, and then started again", async ({ page }) => {
  // Only coarse levels are fetched for this view, and nothing ahead. The rest is requested for the surface.
  await page.addInitScript(saveData);
  await openDialog(page, "&camera=30,20,3300,63.5,63.5,63.5");
  const release = await hold(page, /\/v1\/volumes\/bucky/);
  await saveButton(page).click();
  await expect(page.getByRole("progressbar", { name: "Saving the surface" })).toBeVisible();
  await expect(saveButton(page)).toBeDisabled();
  const cancel = page.getByRole("button", { name: "Cancel", exact: true });
  await page.keyboard.press("Escape"); // discards nothing
  await expect(cancel).toBeFocused();
  await expect(page.getByRole("progressbar", { name: "Saving the surface" })).toBeVisible();
  await cancel.click();
  await expect(page.getByText("Cancelled")).toBeVisible();
  release();
  expect((await save(page)).equals(extracted())).toBe(true);
});

test("states lengths in voxels if the spacing is unknown, and offers to enter it", async ({
  page,
}) => {
  buildUnspaced(join(folder, "unspaced"));
  const other = await serve([join(folder, "unspaced.isosplat")]);
  await page.addInitScript(saveData);
  await page.goto(`${other.url}?volume=unspaced&isovalue=100&camera=30,20,3300,63.5,63.5,63.5`);
  await complete(page);
  await page.getByRole("button", { name: "Save the surface" }).click();
  const dialog = page.locator("wa-dialog[open]");
  for (const [format, words] of [
    ["stl", "lengths are in voxels"],
    ["ply", "lengths are in voxels"],
    ["glb", "a voxel has 1 mm in this file"],
  ] as const) {
    await page.getByLabel("Format").selectOption(format);
    await expect(dialog).toContainText(words);
    await expect(dialog).not.toContainText("millimetres");
  }
  const enter = dialog.getByRole("button", { name: "Enter…" });
  await expect(enter).toBeEnabled();
  await expect(page.getByRole("status").getByText("triangles")).toBeVisible();
  const release = await hold(page, /\/v1\/volumes\/unspaced/);
  await saveButton(page).click();
  await expect(page.getByRole("progressbar", { name: "Saving the surface" })).toBeVisible();
  await expect(enter).toBeDisabled(); // would discard the file
  release();
  await expect(page.getByText(/^Saved: /)).toBeVisible();
  await enter.click();
  await expect(page.getByRole("textbox", { name: "Along x" })).toBeVisible();
  await page.keyboard.press("Escape");
  await expect(page.getByRole("button", { name: "Save the surface" })).toBeFocused();
  await other.stop();
});

test("says why the surface is open at less than full detail", async ({ page }) => {
  await openDialog(page);
  const closed = page.getByLabel("Closed");
  await expect(closed).toBeChecked();
  await page.getByLabel("Detail").selectOption("1");
  await expect(closed).not.toBeChecked();
  await expect(page.getByText("At less than full detail the surface is saved open")).toBeVisible();
  await page.getByLabel("Format").selectOption("ply"); // which is open at full detail, too
  await expect(page.locator(".closing-note")).toHaveCount(0);
  await page.getByLabel("Format").selectOption("stl");
  await closed.check();
  await expect(page.getByText("Closing may need full detail")).toBeVisible();
  const box = await closed.boundingBox();
  expect(Math.min(box?.width ?? 0, box?.height ?? 0)).toBeGreaterThanOrEqual(18);
  expect(await page.locator("wa-dialog[open] .empty").count()).toBe(0);
});
