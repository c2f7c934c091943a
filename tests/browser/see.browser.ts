// Views along the axes and overlays above the picture, and the findings of axe-core on the page.
import { expect, type Page, test } from "@playwright/test";
import { findings } from "./support/accessibility.ts";
import { demoFolder, type RunningServer, serve } from "./support/server.ts";
import { compare, complete, openSection, savedPicture, settled } from "./support/view.ts";

let server: RunningServer;
test.beforeAll(async () => {
  server = await serve([demoFolder]);
});
test.afterAll(() => server.stop());

/** Azimuth and elevation in the address. */
async function angles(page: Page): Promise<number[]> {
  await settled(page);
  const camera = new URL(page.url()).searchParams.get("camera") ?? "";
  return camera.split(",").slice(0, 2).map(Number);
}

test("views along the axes by key, panel and axes; the box and its parameter in the link", async ({
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

  // Show the whole volume again, from the same side.
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
  const { min, max } = await page.locator(".isovalue-slider").evaluate((slider) => {
    const { min, max } = slider as HTMLInputElement;
    return { min: Number(min), max: Number(max) };
  });
  const at = (value: number) => box.x + ((value - min) / (max - min)) * box.width;
  const middle = box.y + box.height / 2;

  // Drag the mark of the second surface, which was not the active one.
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

test("the clip box has handles while its section is open: mouse, keys, undo, link", async ({
  page,
}) => {
  await page.goto(`${server.url}?volume=bucky&isovalue=100`);
  await complete(page);
  const faces = page.getByRole("group", { name: "Faces of the clip box" }).getByRole("slider");
  await expect(faces).toHaveCount(0);
  await openSection(page, "Clipping");
  await expect(faces).toHaveCount(6);
  const clip = async () => {
    await settled(page);
    return new URL(page.url()).searchParams.get("clip")?.split(",").map(Number) ?? [];
  };

  const lower = page.getByRole("slider", { name: "Lower x face of the clip box" });
  const upper = page.getByRole("slider", { name: "Upper x face of the clip box" });
  const middle = async (handle: typeof lower) => {
    const box = await handle.boundingBox();
    if (!box) throw new Error("not shown");
    return { x: box.x + box.width / 2, y: box.y + box.height / 2 };
  };
  const [from, to] = [await middle(lower), await middle(upper)];
  const at = (share: number) => [
    from.x + share * (to.x - from.x),
    from.y + share * (to.y - from.y),
  ];
  const [x = 0, y = 0] = at(0.3);
  await page.mouse.move(from.x, from.y);
  await page.mouse.down();
  await page.mouse.move(x, y);
  await page.mouse.up();
  const [low = 0, ...others] = await clip();
  expect(low).toBeGreaterThan(0.15);
  expect(low).toBeLessThan(0.45);
  expect(others).toEqual([1, 0, 1, 0, 1]);
  // The handle is at the pointer's last position, and the sliders of the panel agree.
  const now = await middle(lower);
  expect(Math.hypot(now.x - x, now.y - y)).toBeLessThan(1.5);
  await expect(page.locator("wa-slider[label=x][range]")).toHaveJSProperty("minValue", low);

  await upper.focus();
  await upper.press("Shift+ArrowDown");
  expect(await clip()).toEqual([low, 0.9, 0, 1, 0, 1]);
  await upper.press("ArrowLeft");
  expect(await clip()).toEqual([low, 0.89, 0, 1, 0, 1]);
  await expect(upper).toHaveAttribute("aria-valuetext", "x 89 %");
  await expect(upper).toBeFocused();

  await page.keyboard.press("Control+z");
  expect(await clip()).toEqual([low, 0.9, 0, 1, 0, 1]);
  await page.keyboard.press("Control+z");
  expect(await clip()).toEqual([low, 1, 0, 1, 0, 1]);
  await page.keyboard.press("Control+z");
  expect(await clip()).toEqual([]);
  await expect(lower).toHaveAttribute("aria-valuenow", "0");

  // The wheel zooms above a handle as well.
  await upper.hover();
  await page.mouse.wheel(0, -200);
  await expect(page).toHaveURL(/camera=/);

  await page.getByRole("button", { name: "Clipping", exact: true }).click();
  await expect(faces).toHaveCount(0);
});

test("cut faces are closed in the section Clipping, and the link keeps this", {
  tag: "@slow",
}, async ({ page }) => {
  // Slow machines draw other kinds of splats and shading.
  const splats = "kind=exact&shading=exact";
  await page.goto(`${server.url}?volume=bucky&isovalue=100&${splats}&clip=0,1,0.5,1,0,1`);
  await complete(page);
  const open = await savedPicture(page);
  await openSection(page, "Clipping");
  const button = page.getByRole("button", { name: "Close cut faces" });
  await expect(button).toHaveAttribute("aria-pressed", "false");
  await button.click();
  await expect(button).toHaveAttribute("aria-pressed", "true");
  await settled(page);
  const query = new URL(page.url()).searchParams;
  expect(query.get("clip-caps")).toBe("on");
  expect(query.get("clip")).toBe("0,1,0.5,1,0,1");
  const closed = await savedPicture(page);
  expect((await compare(page, open, closed)).differing).toBeGreaterThan(0.01);

  await page.reload();
  await complete(page);
  expect((await compare(page, await savedPicture(page), closed)).differing).toBeLessThan(0.001);
});

test("slices: by buttons and keys; in the picture, the legend, picks, the link and undo", {
  tag: "@slow",
}, async ({ page }) => {
  await page.setViewportSize({ width: 900, height: 560 });
  const splats = "kind=exact&shading=exact";
  await page.goto(`${server.url}?volume=bucky&isovalue=100&${splats}&clip=0,1,0.5,1,0,1`);
  // A slice changes when coarse levels arrive. They are loaded while nothing else is being loaded.
  const prepared = async () => {
    await complete(page);
    await page.waitForFunction(() => performance.getEntriesByName("isosplat:prepared").length > 0);
    await settled(page);
  };
  await prepared();
  const setting = async (name: string) => {
    await settled(page);
    return new URL(page.url()).searchParams.get(name);
  };
  const without = await savedPicture(page);
  await openSection(page, "Slices");
  await page.getByRole("button", { name: "Slice across y" }).click();
  await expect(page.getByRole("figure")).toContainText("no values");
  expect(await setting("slices")).toBe(`,${64 / 127},`);
  const middle = await savedPicture(page);
  expect((await compare(page, without, middle)).differing).toBeGreaterThan(0.02);

  // A pick on the slice, in front of the surface, gives a value other than the isovalue.
  await openSection(page, "Measure");
  await page.getByRole("button", { name: "Point", exact: true }).click();
  const { width = 0, height = 0 } = (await page.getByRole("application").boundingBox()) ?? {};
  const position = { x: 0.4 * width, y: 0.5 * height };
  await page.getByRole("application").click({ position });
  await expect(page.locator(".measurement-facts.quiet")).toHaveText(/value (?!100\b)/);
  await page.getByRole("button", { name: "Remove Point 1" }).click();

  const slider = page.getByRole("slider", { name: "Slice across y" });
  await slider.press("ArrowRight");
  expect(await setting("slices")).toBe(`,${65 / 127},`);
  const field = page.getByRole("textbox", { name: "Voxel along y" });
  await field.fill("95.25");
  await field.press("Enter");
  expect(await setting("slices")).toBe(`,${95.25 / 127},`);
  expect((await compare(page, middle, await savedPicture(page))).differing).toBeGreaterThan(0.02);

  await page.getByRole("textbox", { name: "White at" }).fill("150");
  await page.getByRole("textbox", { name: "White at" }).press("Enter");
  await expect(page.getByRole("figure")).toContainText("150");
  expect(await setting("slice-range")).toBe("0.5,150");

  const grey = await savedPicture(page);
  const chooser = page.getByRole("combobox", { name: "Colours" });
  await chooser.click();
  await page.getByRole("option", { name: "Magma" }).click();
  expect(await setting("slice-colours")).toBe("map");
  expect(await setting("map")).toBe("magma");
  await expect(page.locator(".legend-colours")).toHaveAttribute("style", /rgb\(|#(?!000|fff)/);
  expect((await compare(page, grey, await savedPicture(page))).differing).toBeGreaterThan(0.02);
  await chooser.click();
  await page.getByRole("option", { name: "Grey" }).click();
  expect(await setting("slice-colours")).toBeNull();
  expect((await compare(page, grey, await savedPicture(page))).differing).toBeLessThan(0.001);

  await page.getByRole("button", { name: "Slice across the view" }).click();
  await expect(page.getByRole("slider", { name: "Oblique slice" })).toBeVisible();
  expect((await setting("slice-plane"))?.split(",")).toHaveLength(4);
  const both = await savedPicture(page);
  await page.getByRole("application").press("Control+z");
  expect(await setting("slice-plane")).toBeNull();
  await page.getByRole("application").press("Control+Shift+Z");
  expect((await setting("slice-plane"))?.split(",")).toHaveLength(4);
  await page.reload();
  await prepared();
  expect((await compare(page, await savedPicture(page), both)).differing).toBeLessThan(0.001);
});

for (const theme of ["light", "dark"] as const) {
  test(`axe-core finds nothing serious in the ${theme} theme`, async ({ page }) => {
    await page.emulateMedia({ colorScheme: theme });
    await page.goto(server.url);
    await expect(page.getByRole("link", { name: /bucky/ }).first()).toBeVisible();
    expect(await findings(page)).toEqual([]);

    const slices = "slices=0.5,,&slice-plane=0,0.6,0.8,20";
    await page.goto(`${server.url}?volume=bucky&isovalue=100&show=axes,scale,box&${slices}`);
    await complete(page);
    for (const name of ["Appearance", "Light", "View", "Clipping", "Slices", "About this volume"]) {
      await openSection(page, name);
    }
    expect(await findings(page)).toEqual([]);
    await page.keyboard.press("?");
    await expect(page.getByRole("dialog")).toBeVisible();
    expect(await findings(page)).toEqual([]);
  });
}
