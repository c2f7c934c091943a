// Files with several volumes: the page asks which one to open. Tests mouse and keys, a phone, and
// German.

import { gzipSync } from "node:zlib";
import { expect, type Page, test } from "@playwright/test";
import { dicomSegmentation } from "../support/dicom_files.ts";
import { tiffOf } from "../support/tiff_files.ts";
import { demoFolder, type RunningServer, serve } from "./support/server.ts";
import { complete } from "./support/view.ts";

const size = 12;
let server: RunningServer;
test.beforeAll(async () => {
  server = await serve([demoFolder]);
});
test.afterAll(() => server.stop());

/** Distances from the middle of a slice, as a value of each pixel. */
const slice = (z: number, scale: number): number[] =>
  Array.from({ length: size * size }, (_, i) => {
    const [x, y] = [(i % size) - size / 2, Math.floor(i / size) - size / 2];
    return Math.min(255, Math.round(scale * Math.hypot(x, y, z - size / 2)));
  });
const slices = (scale: number): number[][] =>
  Array.from({ length: size }, (_, z) => slice(z, scale));

/** A segmentation whose parts are balls. A part with a higher number is larger. */
const segmentation = dicomSegmentation(
  [1, 2].flatMap((segment) =>
    slices(1).map((pixels, z) => ({
      segment,
      z,
      pixels: pixels.map((distance) => Number(distance < 2 + segment)),
    })),
  ),
  size,
  size,
);

function omeOf(images: number): Buffer {
  const pixels = `<Pixels DimensionOrder="XYZCT" Type="uint8" SizeX="${size}" SizeY="${size}" SizeZ="${size}" SizeC="1" SizeT="1" PhysicalSizeX="1" PhysicalSizeY="1" PhysicalSizeZ="1">`;
  const image = (_: unknown, i: number) =>
    `<Image ID="Image:${i}" Name="field ${i + 1}">${pixels}<TiffData IFD="${i * size}" PlaneCount="${size}"/></Pixels></Image>`;
  const description = `<?xml version="1.0" encoding="UTF-8"?><OME xmlns="http://www.openmicroscopy.org/Schemas/OME/2016-06">${Array.from({ length: images }, image).join("")}</OME>`;
  const voxels = Array.from({ length: images }, (_, i) => slices(10 + i).flat()).flat();
  const form = { width: size, height: size, bits: 8, format: 1, description } as const;
  return Buffer.from(tiffOf(form, Uint8Array.from(voxels)));
}

async function choose(page: Page, name: string, content: Uint8Array, query = ""): Promise<void> {
  await page.goto(`${server.url}${query}`);
  const file = { name, mimeType: "application/octet-stream", buffer: Buffer.from(content) };
  await page.locator(".device-drop input").first().setInputFiles(file);
}

const dialog = (page: Page) => page.locator("wa-dialog");
const storeOf = (page: Page) => new URL(page.url()).searchParams.get("src");

test("a segment of a segmentation", async ({ page }) => {
  const opened: (string | null)[] = [];
  for (const name of ["Segment 1 · part 1", "Segment 2 · part 2"]) {
    await choose(page, "parts.dcm", segmentation);
    await expect(dialog(page)).toHaveAttribute("label", "Which segment?");
    await expect(dialog(page).locator(".dialog-form wa-button")).toHaveCount(2);
    await page.getByRole("button", { name }).click();
    await complete(page);
    await expect(page.locator(".volume-name")).toHaveText("parts");
    opened.push(storeOf(page));
  }
  expect(opened[0]).toMatch(/^device:[0-9a-f]{32}$/);
  expect(opened[1]).not.toBe(opened[0]);
});

test("a segment by keys; Escape chooses none", async ({ page }) => {
  await choose(page, "parts.dcm", segmentation);
  const second = page.getByRole("button", { name: "Segment 2 · part 2" });
  await expect(second).toBeVisible();
  for (let presses = 0; presses < 6; ++presses) {
    if (await second.evaluate((button) => button.matches(":focus"))) break;
    await page.keyboard.press("Tab");
  }
  await page.keyboard.press("Enter");
  await complete(page);
  await choose(page, "parts.dcm", segmentation);
  await expect(second).toBeVisible();
  await page.keyboard.press("Escape");
  await expect(dialog(page)).toHaveCount(0);
  await expect(page.locator(".task-card")).toHaveCount(0);
});

test("a series of a TIFF file", async ({ page }) => {
  await choose(page, "fields.ome.tif", omeOf(3));
  await page.getByRole("button", { name: /field 3/ }).click();
  await complete(page);
  await expect(page.locator(".volume-name")).toHaveText("fields.ome");
});

test("a time step of many, in German, on a phone", async ({ page }) => {
  await page.setViewportSize({ width: 390, height: 800 });
  const steps = 30;
  const header = `NRRD0004\ntype: uint8\ndimension: 4\nsizes: ${size} ${size} ${size} ${steps}\nkinds: domain domain domain time\nspacings: 1 1 1 nan\nencoding: raw\n\n`;
  const voxels = Array.from({ length: steps }, (_, i) => slices(5 + i).flat()).flat();
  const content = Buffer.concat([Buffer.from(header), Buffer.from(voxels)]);
  await choose(page, "beat.nrrd", content, "?lang=de");
  const list = page.getByRole("combobox", { name: "Welcher Zeitschritt?" });
  await expect(list.locator("option")).toHaveCount(steps);
  await list.selectOption("Zeitschritt 21");
  await list.press("Tab");
  await page.keyboard.press("Enter");
  await expect(page.locator(".status-state")).toHaveText("vollständig", { timeout: 30_000 });
  await expect(page.locator(".volume-name")).toHaveText("beat");
});

test("a truncated file is read on request", async ({ page }) => {
  const header = `NRRD0004\ntype: uint8\ndimension: 3\nsizes: ${size} ${size} ${size}\nspacings: 1 1 1\nencoding: raw\n\n`;
  const content = Buffer.concat([Buffer.from(header), Buffer.from(slices(9).flat())]);
  await choose(page, "cut.nrrd", content.subarray(0, content.length - 100));
  await expect(dialog(page)).toContainText("The file is incomplete, or its header is wrong.");
  await expect(dialog(page)).toContainText(`expected ${size ** 3} bytes of voxels`);
  expect(await dialog(page).textContent()).not.toContain("--");
  await page.keyboard.press("Escape");
  const message = page.locator(".task-card [role=alert]");
  await expect(message).toContainText("The file is incomplete, or its header is wrong.");
  expect(await message.textContent()).not.toContain("--");
  await choose(page, "cut.nrrd", content.subarray(0, content.length - 100));
  await page.getByRole("button", { name: "Read it: missing voxels have no value" }).click();
  await complete(page);
});

test("a compressed file that is cut says so in German, without options of the program", async ({
  page,
}) => {
  const header = `NRRD0004\ntype: uint8\ndimension: 3\nsizes: ${size} ${size} ${size}\nspacings: 1 1 1\nencoding: gzip\n\n`;
  const voxels = gzipSync(Buffer.from(slices(9).flat()));
  const content = Buffer.concat([Buffer.from(header), voxels.subarray(0, voxels.length / 2)]);
  await choose(page, "cut.nrrd", content, "?lang=de");
  const shown = page.locator("wa-dialog[open], .task-card [role=alert]");
  await expect(shown).toContainText("unvollständig");
  expect(await shown.textContent()).not.toContain("--");
});

test("a text with the name of a volume is named as text", async ({ page }) => {
  await choose(page, "notes.nrrd", Buffer.from("Notes of the scan\nFirst line\n"));
  await expect(page.locator(".task-card [role=alert]")).toContainText(
    "notes.nrrd is not NRRD, as its name says: it contains text, which begins with “Notes of the scan…”",
  );
});

test("a text of a known kind is explained, with what to do", async ({ page }) => {
  const pointer = "version https://git-lfs.github.com/spec/v1\noid sha256:4d7a2146\nsize 5\n";
  await choose(page, "scan.nrrd", Buffer.from(pointer));
  const message = page.locator(".task-card [role=alert]");
  await expect(message).toContainText("git lfs pull --include scan.nrrd");
  await expect(message).not.toContainText("as its name says");
});
