import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { expect, test } from "@playwright/test";
import { regionAt, writeLabelledStore } from "../support/field_volumes.ts";
import { decodePng } from "./support/pixels.ts";
import { type RunningServer, serve } from "./support/server.ts";
import { complete, openSection, savedPicture, settled } from "./support/view.ts";

const folder = mkdtempSync(join(tmpdir(), "isosplat-labels-page-"));
let server: RunningServer;

test.beforeAll(async () => {
  server = await serve([writeLabelledStore(folder)]);
});

test.afterAll(async () => {
  await server?.stop();
  rmSync(folder, { recursive: true, force: true });
});

/** From the right, with z upwards: the ball's radius is 25, around z = 35. */
const query = "volume=parcels&isovalue=75.5&camera=90,0,120,75,65,35&theme=light";

test("a surface shows labels in their own colours, from a link", async ({ page }) => {
  await page.goto(`${server.url}?${query}&colour-by=field&field=region`);
  await complete(page);
  await settled(page);
  const legend = page.locator(".legend");
  await expect(legend).toContainText("region");
  await expect(legend.locator("li")).toHaveText(["lower", "middle", "upper"]);
  // Labels have no range, neither in the address nor in the panel.
  expect(page.url()).not.toContain("field-range");
  await openSection(page, "Appearance");
  await expect(page.getByRole("combobox", { name: "Colour" })).toBeVisible();
  await expect(page.getByLabel("Colours from")).toHaveCount(0);
  await expect(page.getByRole("button", { name: "Contour lines" })).toHaveCount(0);

  const { width, height, rgba } = await decodePng(page, await savedPicture(page));
  const colourAt = (share: number): number[] => {
    const at = 4 * (Math.round(share * height) * width + Math.round(width / 2));
    return [...rgba.subarray(at, at + 3)];
  };
  const strongest = (colour: number[]): number => colour.indexOf(Math.max(...colour));
  // In the middle, z = 35.
  expect([0.3, 0.5, 0.7].map((share) => strongest(colourAt(share)))).toEqual([2, 1, 0]);

  await page.getByRole("application").click();
  const { name, value } = regionAt(35);
  await expect(page.locator(".toast")).toContainText(`region ${name} (${value})`);
});
