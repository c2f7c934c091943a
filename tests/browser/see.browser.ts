// Views along the axes and what lies above the picture, in the page; what axe-core says of the page.
import { expect, type Page, test } from "@playwright/test";
import { findings } from "./support/accessibility.ts";
import { demoFolder, type RunningServer, serve } from "./support/server.ts";
import { complete, openSection, settled } from "./support/view.ts";

let server: RunningServer;
test.beforeAll(async () => {
  server = await serve([demoFolder]);
});
test.afterAll(() => server.stop());

/** Azimuth and elevation as the address has them. */
async function angles(page: Page): Promise<number[]> {
  await settled(page);
  const camera = new URL(page.url()).searchParams.get("camera") ?? "";
  return camera.split(",").slice(0, 2).map(Number);
}

test("views along the axes by key, panel and axes; the box and its place in the link", async ({
  page,
}) => {
  await page.goto(`${server.url}?volume=bucky&isovalue=100`);
  await complete(page);
  const overlay = page.locator(".overlay");
  await expect(overlay.getByRole("img", { name: /Scale: the bar is \d+ mm/ })).toBeVisible();

  await page.getByRole("application").press("3");
  expect(await angles(page)).toEqual([90, 0]);
  await overlay.getByRole("button", { name: "View from y", exact: true }).click();
  expect(await angles(page)).toEqual([180, 0]);
  await openSection(page, "View");
  await page.locator(".panel").getByRole("button", { name: "View from z" }).click();
  expect(await angles(page)).toEqual([0, 90]);

  // The whole volume again, from the same side.
  await page.getByRole("application").press("+");
  await page.getByRole("application").press("+");
  const distance = () =>
    Number(new URL(page.url()).searchParams.get("camera")?.split(",")[2] ?? Number.NaN);
  await settled(page);
  const near = distance();
  await page.getByRole("button", { name: "Fit" }).click();
  expect(await angles(page)).toEqual([0, 90]);
  expect(distance()).toBeGreaterThan(1.2 * near);

  await expect(page.locator(".overlay-box")).toHaveCount(0);
  await page.getByRole("button", { name: "Box", exact: true }).click();
  await expect(page.locator(".overlay-box text").first()).toBeVisible();
  await page.getByRole("button", { name: "Scale bar" }).click();
  await settled(page);
  expect(new URL(page.url()).searchParams.get("show")).toBe("axes,box");
  await page.reload();
  await expect(page.locator(".overlay-box text").first()).toBeVisible();
  await expect(page.locator(".overlay-scale")).toHaveCount(0);
});

test("the histogram: cost, marks of several surfaces, fine steps by wheel, sweep", async ({
  page,
}) => {
  await page.goto(`${server.url}?volume=bucky&isovalue=60,180&colour=d9ccb3,c8553d&opacity=0.4,1`);
  await complete(page);
  await expect(page.locator(".isovalue-cost")).toHaveText(
    /^\s*about [\d.]+ k active cells, [\d.]+ KB at full detail\s*$/,
  );
  const isovalues = async () => {
    await settled(page);
    return (new URL(page.url()).searchParams.get("isovalue") ?? "").split(",").map(Number);
  };
  const histogram = page.locator("#histogram");
  const box = await histogram.boundingBox();
  if (!box) throw new Error("no histogram");
  const { min, max } = await page.locator("wa-slider.isovalue-slider").evaluate((slider) => {
    const { min, max } = slider as HTMLElement & { min: number; max: number };
    return { min, max };
  });
  const at = (value: number) => box.x + ((value - min) / (max - min)) * box.width;
  const middle = box.y + box.height / 2;

  // The mark of the second surface, which was not the active one.
  await page.mouse.move(at(180), middle);
  await page.mouse.down();
  await page.mouse.move(at(200), middle);
  await page.mouse.up();
  const [first, second] = await isovalues();
  expect(first).toBe(60);
  expect(Math.abs((second ?? 0) - 200)).toBeLessThan(2);

  await page.mouse.wheel(0, -100);
  expect(await isovalues()).toEqual([60, (second ?? 0) + 0.5]);

  const logarithmic = page.getByRole("button", { name: "Logarithmic" });
  await logarithmic.click();
  await expect(logarithmic).toHaveAttribute("aria-pressed", "false");

  const field = page.getByRole("textbox", { name: "Isovalue" });
  const before = await field.inputValue();
  await page.getByRole("button", { name: "Sweep" }).click();
  await expect(field).not.toHaveValue(before);
  await page.getByRole("button", { name: "Stop" }).click();
  const [still, moved] = await isovalues();
  expect(still).toBe(60);
  expect(moved).not.toBe(second);
});

for (const theme of ["light", "dark"] as const) {
  test(`axe-core finds nothing serious in the ${theme} theme`, async ({ page }) => {
    await page.emulateMedia({ colorScheme: theme });
    await page.goto(server.url);
    await expect(page.getByRole("link", { name: /bucky/ }).first()).toBeVisible();
    expect(await findings(page)).toEqual([]);

    await page.goto(`${server.url}?volume=bucky&isovalue=100&show=axes,scale,box`);
    await complete(page);
    for (const name of ["Appearance", "Light", "View", "Clipping", "About this volume"]) {
      await openSection(page, name);
    }
    expect(await findings(page)).toEqual([]);
    await page.keyboard.press("?");
    await expect(page.getByRole("dialog")).toBeVisible();
    expect(await findings(page)).toEqual([]);
  });
}
