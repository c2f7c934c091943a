// OME-Zarr images in a folder or a ZIP of this device: dropped, built and kept.
import { mkdtempSync, readdirSync, readFileSync, rmSync, statSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join, relative } from "node:path";
import { expect, test } from "@playwright/test";
import { writeArray, writeGroup } from "../support/zarr.ts";
import { zipOf } from "../support/zip_files.ts";
import { drop } from "./support/drop.ts";
import { demoFolder, type RunningServer, serve } from "./support/server.ts";
import { complete } from "./support/view.ts";

let server: RunningServer;
let folder: string;

test.beforeAll(async () => {
  folder = mkdtempSync(join(tmpdir(), "isosplat-zarr-folder-"));
  server = await serve([demoFolder]);
});
test.afterAll(async () => {
  await server?.stop();
  rmSync(folder, { recursive: true, force: true });
});

/** A ball in two scales, of 40 and 20 voxels. */
async function writeBall(path: string): Promise<void> {
  const sizes = [40, 20];
  const axes = ["z", "y", "x"].map((name) => ({ name, type: "space", unit: "millimeter" }));
  const datasets = sizes.map((size, i) => ({
    path: String(i),
    coordinateTransformations: [{ type: "scale", scale: Array(3).fill(40 / size) }],
  }));
  writeGroup(path, 3, { ome: { version: "0.5", multiscales: [{ axes, datasets }] } });
  for (const [i, size] of sizes.entries()) {
    await writeArray(join(path, String(i)), {
      version: 3,
      shape: [size, size, size],
      chunks: [16, 16, 16],
      isBlosc: true,
      value: (index) =>
        Math.round(500 * Math.hypot(...index.map((at) => (2 * at - size + 1) / size))),
    });
  }
}

test("a folder and its ZIP become the same store", async ({ page }) => {
  const ball = join(folder, "ball.ome.zarr");
  await writeBall(ball);
  await page.goto(server.url);
  await drop(page, [ball]);
  await page.getByRole("button", { name: /40 × 40 × 40 voxels · 128 KB/ }).click();
  // The smaller scale is shown first.
  await expect(page.getByText("40 × 40 × 40, 16 bit")).toBeVisible();
  await complete(page);
  await expect(page.locator(".volume-name")).toHaveText("ball");
  const { searchParams } = new URL(page.url());
  const store = searchParams.get("src");
  expect(store).toMatch(/^device:[0-9a-f]{32}$/);

  // The same files in a ZIP.
  const names = readdirSync(ball, { recursive: true, encoding: "utf8" })
    .map((name) => join(ball, name))
    .filter((path) => statSync(path).isFile());
  const zip = join(folder, "ball.zip");
  writeFileSync(
    zip,
    zipOf(names.map((path) => ({ name: relative(folder, path), content: readFileSync(path) }))),
  );
  await page.goto(server.url);
  await expect(page.locator(".device-card")).toContainText("ball");
  await drop(page, [zip]);
  await page.getByRole("button", { name: /40 × 40 × 40 voxels/ }).click();
  await expect(page.getByText("40 × 40 × 40, 16 bit")).toBeVisible();
  await complete(page);
  expect(new URL(page.url()).searchParams.get("src")).toBe(store);
});

test("a cancelled choice opens nothing; a damaged image is a fault", async ({ page }) => {
  const ball = join(folder, "damaged.ome.zarr");
  await writeBall(ball);
  await page.goto(server.url);
  await drop(page, [ball]);
  await expect(page.getByRole("button", { name: /20 × 20 × 20 voxels/ })).toBeVisible();
  await page.keyboard.press("Escape");
  await expect(page.getByRole("heading", { name: "Volumes" })).toBeVisible();
  rmSync(join(ball, "1", "zarr.json"));
  await drop(page, [ball]);
  await expect(page.locator(".task-card [role=alert]")).toContainText(
    "damaged.ome.zarr/1: expected zarr.json",
  );
});
