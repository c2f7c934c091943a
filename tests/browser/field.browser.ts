import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { expect, type Page, test } from "@playwright/test";
import { pressure, writeFieldStore } from "../support/field_volumes.ts";
import { decodePng } from "./support/pixels.ts";
import { type RunningServer, serve } from "./support/server.ts";
import { complete, openSection, savedPicture, settled } from "./support/view.ts";

const folder = mkdtempSync(join(tmpdir(), "isosplat-field-page-"));
let server: RunningServer;

test.beforeAll(async () => {
  server = await serve([writeFieldStore(folder)]);
});

test.afterAll(async () => {
  await server?.stop();
  rmSync(folder, { recursive: true, force: true });
});

type Colour = [number, number, number];

/** The colours of the surface in the middle of the picture, a fifth of the picture above it, and as far below. */
async function colours(page: Page): Promise<Record<"top" | "middle" | "bottom", Colour>> {
  const { width, height, rgba } = await decodePng(page, await savedPicture(page));
  const at = (share: number): Colour => {
    const pixel = 4 * (Math.round(share * height) * width + Math.round(width / 2));
    return [rgba[pixel] ?? 0, rgba[pixel + 1] ?? 0, rgba[pixel + 2] ?? 0];
  };
  return { top: at(0.3), middle: at(0.5), bottom: at(0.7) };
}

/** A busy machine leaves out the smooth edges of one of two pictures. */
function expectClose(a: Awaited<ReturnType<typeof colours>>, b: typeof a): void {
  for (const place of ["top", "middle", "bottom"] as const) {
    a[place].forEach((channel, i) => {
      expect(Math.abs(channel - (b[place][i] ?? 0))).toBeLessThan(16);
    });
  }
}

/** From the right, with z upwards: the field increases upwards. */
const query = "volume=ball&isovalue=75.5&camera=90,0,120,75,65,35&theme=light";

/** Viridis is violet at its lower end, and yellow at its upper end. */
const yellowness = ([red, green, blue]: Colour): number => red + green - 2 * blue;

test("a surface shows the values of a field by colours, with a legend, from a link", async ({
  page,
}) => {
  await page.goto(`${server.url}?${query}&colour-by=field&field=pressure`);
  await complete(page);
  await settled(page);
  const legend = page.locator(".legend");
  await expect(legend).toContainText("pressure");
  // The range is that of the values on the surface, not that of the whole field.
  const [low, high] = (await legend.locator(".legend-ends span").allTextContents()).map(Number);
  expect(low).toBeGreaterThan(700);
  expect(high).toBeLessThan(2100);
  await expect(page).toHaveURL(/field=pressure&field-range=[\d.]+,[\d.]+/);
  const { top, middle, bottom } = await colours(page);
  expect(yellowness(top)).toBeGreaterThan(yellowness(middle) + 30);
  expect(yellowness(middle)).toBeGreaterThan(yellowness(bottom) + 30);

  // A click states the value there: on the axis of view, at the sphere's nearest point.
  await page.getByRole("application").click();
  const toast = page.locator(".toast");
  await expect(toast).toContainText("pressure");
  const [, value] = (await toast.textContent())?.match(/pressure ([\d.]+)/) ?? [];
  expect(Math.abs(Number(value) - pressure(100, 65, 35))).toBeLessThan(12);

  // The link shows the same colours, without fitting them again.
  await page.goto(`${page.url().replace(/field-range=[^&]*/, "field-range=0,10000")}`);
  await complete(page);
  await settled(page);
  await expect(page).toHaveURL(/field-range=0,10000/);
  await expect(legend).toContainText("10");
  const low2 = await colours(page);
  expect(Math.abs(yellowness(low2.top) - yellowness(low2.bottom))).toBeLessThan(60);

  // A measured point has the value too.
  await openSection(page, "Measure");
  await page.getByRole("button", { name: "Point", exact: true }).click();
  await page.getByRole("application").press("Enter");
  const facts = page.locator(".measurement-facts.quiet");
  await expect(facts).toContainText("pressure");
  const [, measured] = (await facts.textContent())?.match(/pressure ([\d.]+)/) ?? [];
  expect(Math.abs(Number(measured) - pressure(100, 65, 35))).toBeLessThan(12);
  await expect(page.locator(".measurement-value")).toHaveText(/\s(\d+(\.\d)?, ){2}\d+(\.\d)?\s*$/);
});

test("a field is chosen in the panel, and undone", async ({ page }) => {
  await page.goto(`${server.url}?${query}`);
  await complete(page);
  await settled(page);
  await openSection(page, "Appearance");
  const plain = await colours(page);
  const choose = async (label: string, option: string): Promise<void> => {
    await page.locator(`wa-select[label="${label}"]`).click();
    await page.getByRole("option", { name: option, exact: true }).click();
  };
  await choose("Colour", "pressure");
  await expect(page.locator(".legend")).toContainText("pressure");
  await expect(page).toHaveURL(/field-range=/);
  await settled(page);
  const rangeOf = (): string => /field-range=([^&]*)/.exec(page.url())?.[1] ?? "";
  const fitted = rangeOf();
  const coloured = await colours(page);
  expect(yellowness(coloured.top)).toBeGreaterThan(yellowness(coloured.bottom) + 60);

  // The histogram has the values on the surface alone: most bins are empty.
  const histogram = page.getByRole("img", { name: "occur on the surface" });
  await expect(histogram).toBeVisible();
  const bars = (await histogram.locator("path").getAttribute("d"))?.match(/V[^H]*/g) ?? [];
  const heights = bars.slice(0, 256).map((bar) => 1 - Number(bar.slice(1)));
  expect(Math.max(...heights)).toBe(1);
  expect(heights.filter((height) => height === 0).length).toBeGreaterThan(64);

  await choose("Number of colours", "4 colours");
  await expect(page).toHaveURL(/field-steps=4/);
  await page.getByRole("button", { name: "Whole range" }).click();
  const [, to] = /field-range=[^,]*,([\d.]+)/.exec(page.url()) ?? [];
  await expect(page).not.toHaveURL(new RegExp(`field-range=[^,]*,${to}&`));
  await settled(page);
  await page.getByRole("button", { name: "Fit to the surface" }).click();
  await expect.poll(rangeOf).toBe(fitted);
  await settled(page);
  await page.getByLabel("Colours to").fill("2000");
  await page.getByLabel("Colours to").press("Enter");
  await expect(page).toHaveURL(/field-range=[^,]*,2000/);
  await settled(page);

  // Every step of this is undone; the range that was fitted is none.
  await page.getByRole("application").focus();
  for (let i = 0; i < 4; ++i) await page.keyboard.press("Control+z");
  await expect(page).toHaveURL(/field-range=/);
  await expect(page).not.toHaveURL(/field-steps/);
  await settled(page);
  await page.keyboard.press("Control+z");
  await expect(page).not.toHaveURL(/colour-by/);
  await expect(page.locator(".legend")).toHaveCount(0);
  await settled(page);
  expectClose(await colours(page), plain);
});

/** Dark and bright pixels beside others, in the column of pixels in the middle: one for each line. */
async function linesAcross(page: Page): Promise<number> {
  const { width, height, rgba } = await decodePng(page, await savedPicture(page));
  const column = Array.from({ length: height }, (_, y) => {
    const at = 4 * (y * width + (width >> 1));
    return (rgba[at] ?? 0) + (rgba[at + 1] ?? 0) + (rgba[at + 2] ?? 0);
  });
  return column.filter((here, y) => {
    const [above = here, below = here] = [column[y - 4], column[y + 4]];
    const [before = here, after = here] = [column[y - 1], column[y + 1]];
    const isDark = here < Math.min(above, below) - 90 && here <= before && here < after;
    const isBright = here > Math.max(above, below) + 90 && here >= before && here > after;
    return isDark || isBright;
  }).length;
}

const coloured = `${query}&lang=en&colour-by=field&field=pressure&field-range=800,2000`;

test("contour lines are switched on with a fitting interval, and are in link, legend and undo", async ({
  page,
}) => {
  await page.goto(`${server.url}?${coloured}`);
  await complete(page);
  await settled(page);
  await openSection(page, "Appearance");
  const without = await linesAcross(page);
  const contour = page.getByRole("button", { name: "Contour lines" });
  await expect(contour).toHaveAttribute("aria-pressed", "false");
  await contour.click();
  // A tenth of the range, rounded.
  await expect(page).toHaveURL(/field-lines=100(&|$)/);
  await settled(page);
  await expect(page.locator(".legend")).toContainText("Lines every 100");
  await expect(page.locator(".legend-colours i")).toHaveCount(13);
  expect(await linesAcross(page)).toBeGreaterThan(without + 4);
  const interval = page.getByLabel("Interval");
  await interval.fill("300");
  await interval.press("Enter");
  await expect(page).toHaveURL(/field-lines=300(&|$)/);
  // What is no interval is not taken over.
  for (const text of ["0", "-5", "abc", ""]) {
    await interval.fill(text);
    await interval.press("Enter");
    await expect(interval).toHaveValue("300");
  }
  await settled(page);
  await page.locator('wa-select[label="Scale of the colours"]').click();
  await page.getByRole("option", { name: "Logarithmic", exact: true }).click();
  await expect(page.getByLabel("Interval in decades")).toHaveValue("0.05");
  await expect(page.locator(".legend")).toContainText("Lines every 0.05 decades");
  await settled(page);

  await page.getByRole("application").focus();
  for (const lines of [/field-lines=300(&|$)/, /field-lines=100(&|$)/]) {
    await page.keyboard.press("Control+z");
    await expect(page).toHaveURL(lines);
    await settled(page);
  }
  await page.keyboard.press("Control+z");
  await expect(page).not.toHaveURL(/field-lines/);
  await expect(page.locator(".legend-colours i")).toHaveCount(0);
});

test("a link has contour lines, and none at an interval that is too small, or none", async ({
  page,
}) => {
  const counts: number[] = [];
  for (const interval of ["300", "1e-300", "NaN"]) {
    await page.goto(`${server.url}?${coloured}&field-lines=${interval}`);
    await complete(page);
    await settled(page);
    await expect(page.locator(".legend-colours i")).toHaveCount(interval === "300" ? 4 : 0);
    await expect(page.getByText("Lines every")).toHaveCount(interval === "300" ? 1 : 0);
    counts.push(await linesAcross(page));
  }
  const [lines = 0, tooSmall = 0, none] = counts;
  expect(lines).toBeGreaterThan(tooSmall);
  expect(tooSmall).toBe(none);
});

test("colours return with the context, and follow another isovalue", async ({ page }) => {
  await page.goto(`${server.url}?${query}&colour-by=field&field=pressure&field-range=800,2000`);
  await complete(page);
  await settled(page);
  const before = await colours(page);
  await page.evaluate(async () => {
    const canvas = document.querySelector("canvas.picture, main canvas") as HTMLCanvasElement;
    const context = canvas.getContext("webgl2")?.getExtension("WEBGL_lose_context");
    context?.loseContext();
    await new Promise((resolve) => setTimeout(resolve, 200));
    context?.restoreContext();
  });
  await complete(page);
  await settled(page);
  expectClose(await colours(page), before);
  await page.locator(".isovalue-field").fill("80.5");
  await page.locator(".isovalue-field").press("Enter");
  await expect(page).toHaveURL(/isovalue=80.5/);
  await complete(page);
  await settled(page);
  const { top, bottom } = await colours(page);
  expect(yellowness(top)).toBeGreaterThan(yellowness(bottom) + 30);
});

test("a scene shows a field, and a saved scene keeps it", async ({ page }) => {
  const open = async (text: string) => {
    await page.goto(`${server.url}?theme=light`);
    const file = { name: "ball.scene.json", mimeType: "application/json" };
    await page
      .locator(".device-drop input")
      .first()
      .setInputFiles({ ...file, buffer: Buffer.from(text) });
    await complete(page);
    await settled(page);
    await expect(page.locator(".legend")).toContainText("pressure");
    return colours(page);
  };
  const field = { name: "pressure", range: [800, 2000], scale: "symmetric", steps: 6, lines: 250 };
  const scene = {
    format: "isosplat-scene",
    version: 1,
    layers: [75.5, 30.5].map((isovalue) => ({
      store: `${server.url}v1/volumes/ball`,
      surfaces: [{ isovalue }],
    })),
    camera: { target: [75, 65, 35], distance: 120, azimuth: 90, elevation: 0 },
    look: { colour_by: "field", colour_map: "turbo", field: { ...field, unknown: "kept" } },
  };
  const before = await open(JSON.stringify(scene));
  await expect(page.locator(".legend-ends span").first()).toHaveText(/^[−-]2,?000$/);
  const download = page.waitForEvent("download");
  await page.getByRole("button", { name: "Save the scene" }).click();
  const text = readFileSync(await (await download).path(), "utf8");
  expect(JSON.parse(text).look).toMatchObject({
    colour_by: "field",
    colour_map: "turbo",
    field: { ...field, unknown: "kept" },
  });
  expectClose(await open(text), before);
});
