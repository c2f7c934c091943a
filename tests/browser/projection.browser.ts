// The orthographic camera in the page: keys, panel, link and gestures, and comparison with the
// native picture. Also undo and redo of the view, and pictures without background.
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { expect, type Page, test } from "@playwright/test";
import { drawNatively } from "./support/native_picture.ts";
import { demoFolder, type RunningServer, serve } from "./support/server.ts";
import { compare, complete, openSection, savedPicture, settled } from "./support/view.ts";

let server: RunningServer;
test.beforeAll(async () => {
  server = await serve([demoFolder]);
});
test.afterAll(() => server.stop());

function parameter(page: Page, name: string): string | null {
  return new URL(page.url()).searchParams.get(name);
}

/** The target of the camera, and its distance. */
async function view(page: Page): Promise<{ distance: number; target: number[] }> {
  await settled(page);
  const numbers = (parameter(page, "camera") ?? "").split(",").map(Number);
  return { distance: numbers[2] ?? Number.NaN, target: numbers.slice(3, 6) };
}

test("P and the panel change the projection, which is kept in the link", async ({ page }) => {
  await page.goto(`${server.url}?volume=bucky&isovalue=100`);
  await complete(page);
  await page.getByRole("application").press("p");
  await settled(page);
  expect(parameter(page, "projection")).toBe("orthographic");
  await openSection(page, "View");
  const button = page.getByRole("button", { name: "Orthographic" });
  await expect(button).toHaveAttribute("aria-pressed", "true");

  // Axis views and the reset keep it.
  await page.getByRole("application").press("1");
  await page.getByRole("application").press("r");
  await settled(page);
  expect(parameter(page, "projection")).toBe("orthographic");
  await page.reload();
  await complete(page);
  await openSection(page, "View");
  await expect(button).toHaveAttribute("aria-pressed", "true");
  await expect(page.getByText("too far from the volume")).toHaveCount(0);

  await button.click();
  await settled(page);
  expect(parameter(page, "projection")).toBeNull();

  await page.goto(`${server.url}?volume=bucky&isovalue=100&projection=fisheye`);
  await expect(page.getByText("projection=fisheye")).toBeVisible();
});

test("an orthographic link shows what the native renderer draws", async ({ page }) => {
  await page.setViewportSize({ width: 700, height: 500 });
  const light = { occlusion: "0,0.2", shadow: "0,0.1", shade: "0" };
  const settings = Object.entries(light).map(([name, value]) => `&${name}=${value}`);
  await page.goto(
    `${server.url}?volume=bucky&isovalue=100&projection=orthographic&kind=exact` +
      `&background=ffffff&shading=exact${settings.join("")}`,
  );
  await complete(page);
  await page.getByRole("application").press("+");
  await complete(page);
  await settled(page);
  const picture = await savedPicture(page);
  const size = await page.getByRole("application").evaluate((canvas) => {
    const { width, height } = canvas as HTMLCanvasElement;
    return { width, height };
  });
  const native = drawNatively(join(demoFolder, "bucky.isosplat"), {
    isovalue: 100,
    camera: parameter(page, "camera") ?? "",
    projection: "orthographic",
    kind: "exact",
    ...size,
    light: { ...light, shading: "exact" },
  });
  const difference = await compare(page, picture, native);
  expect(difference.covered).toBeGreaterThan(0.2);
  expect(difference.differing).toBeLessThan(0.002);
});

test("zooming keeps the point under the pointer, exactly at any depth", async ({ page }) => {
  await page.goto(
    `${server.url}?volume=bucky&isovalue=100&projection=orthographic` + "&camera=0,0,100,16,16,16",
  );
  await complete(page);
  await expect(page.getByText("too far from the volume")).toHaveCount(0);
  const box = await page.getByRole("application").boundingBox();
  if (!box) throw new Error("no canvas");
  const at = { x: Math.round(box.x + box.width * 0.7), y: Math.round(box.y + box.height * 0.4) };
  const before = await view(page);
  await page.mouse.move(at.x, at.y);
  await page.mouse.wheel(0, -200);
  await expect.poll(async () => (await view(page)).distance).toBeLessThan(before.distance);
  const after = await view(page);
  // World units per CSS pixel, and the vector from the middle of the picture to the pointer.
  const perPixel = (distance: number) => (2 * distance * Math.tan(Math.PI / 12)) / box.height;
  const right = at.x - box.x - box.width / 2;
  const down = at.y - box.y - box.height / 2;
  const under = ({ distance, target: [x = 0, , z = 0] }: typeof before) => [
    x + right * perPixel(distance),
    z - down * perPixel(distance),
  ];
  const [x0 = 0, z0 = 0] = under(before);
  const [x1 = 0, z1 = 0] = under(after);
  expect(Math.abs(x1 - x0)).toBeLessThan(1e-6);
  expect(Math.abs(z1 - z0)).toBeLessThan(1e-6);
});

test("changes of the view are undone and redone", { tag: "@slow" }, async ({ page }) => {
  test.setTimeout(180_000);
  await page.goto(`${server.url}?volume=bucky&isovalue=100&camera=30,20,330,63.5,63.5,63.5`);
  await complete(page);
  const picture = page.getByRole("application");
  const views: string[] = [];
  const rest = async () => {
    await settled(page);
    views.push(new URL(page.url()).search);
  };
  await rest();
  for (const key of ["1", "p", "]"]) {
    await picture.press(key);
    await rest();
  }
  await openSection(page, "Appearance");
  await page.getByRole("button", { name: "Grey" }).click();
  await rest();
  expect(new Set(views).size).toBe(5);

  for (const view of views.slice(0, 4).reverse()) {
    await picture.press("Control+z");
    await settled(page);
    expect(new URL(page.url()).search).toBe(view);
  }
  await openSection(page, "View");
  await expect(page.getByRole("button", { name: "Undo", exact: true })).toBeDisabled();
  await page.getByRole("button", { name: "Redo", exact: true }).click();
  await settled(page);
  expect(new URL(page.url()).search).toBe(views[1]);
  await picture.press("Control+Shift+Z");
  await settled(page);
  expect(new URL(page.url()).search).toBe(views[2]);
  // Another change discards the undone ones.
  await picture.press("+");
  await settled(page);
  await expect(page.getByRole("button", { name: "Redo", exact: true })).toBeDisabled();
});

/** The number of transparent pixels of a PNG. Runs in the page. */
async function clearPixels(base64: string): Promise<number> {
  const bytes = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
  const bitmap = await createImageBitmap(new Blob([bytes], { type: "image/png" }));
  const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext("2d");
  context?.drawImage(bitmap, 0, 0);
  const { data } = context?.getImageData(0, 0, bitmap.width, bitmap.height) ?? { data: [] };
  return data.filter((value, i) => i % 4 === 3 && value === 0).length;
}

test("a picture without its background has only the surface", { tag: "@slow" }, async ({
  page,
}) => {
  test.setTimeout(120_000);
  await page.goto(`${server.url}?volume=bucky&isovalue=100&background=ff0000`);
  await complete(page);
  await settled(page);
  await openSection(page, "View");
  const [download] = await Promise.all([
    page.waitForEvent("download"),
    page.getByRole("button", { name: "Save without background" }).click(),
  ]);
  const png = readFileSync(await download.path()).toString("base64");
  const found = await page.evaluate(async (base64) => {
    const bytes = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
    const bitmap = await createImageBitmap(new Blob([bytes], { type: "image/png" }));
    const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext("2d");
    context?.drawImage(bitmap, 0, 0);
    const { data } = context?.getImageData(0, 0, bitmap.width, bitmap.height) ?? { data: [] };
    const counts = { clear: 0, opaque: 0, red: 0 };
    for (let i = 0; i < data.length; i += 4) {
      const [r = 0, g = 0, b = 0, a = 0] = data.slice(i, i + 4);
      if (a === 0) ++counts.clear;
      if (a === 255) ++counts.opaque;
      if (a > 0 && r > 200 && g < 60 && b < 60) ++counts.red;
    }
    return { ...counts, pixels: data.length / 4 };
  }, png);
  expect(found.opaque).toBeGreaterThan(found.pixels / 10);
  expect(found.clear).toBeGreaterThan(found.pixels / 3);
  expect(found.red).toBe(0);
  // The picture on the screen has its background again.
  await settled(page);
  const shown = await compare(page, await savedPicture(page), await savedPicture(page));
  expect(shown.differing).toBe(0);

  // This must hold even if it is saved while the other picture is not finished.
  const pictures: number[] = [];
  page.on("download", async (each) => {
    const saved = readFileSync(await each.path()).toString("base64");
    pictures.push(await page.evaluate(clearPixels, saved));
  });
  await page.evaluate(() => {
    const buttons = [...document.querySelectorAll<HTMLElement>("button, wa-button")];
    const named = (name: RegExp) =>
      buttons.find((b) => name.test(b.textContent ?? "") || name.test(b.ariaLabel ?? ""));
    named(/Save without background/)?.click();
    named(/Save a picture/)?.click();
  });
  await expect.poll(() => pictures.length).toBe(2);
  const [least = -1, most = 0] = pictures.sort((a, b) => a - b);
  expect(least).toBe(0);
  expect(most).toBe(found.clear);
});

test.describe("with motions", () => {
  test.use({ contextOptions: { reducedMotion: "no-preference" } });
  test("views are undone and redone while the view still moves", async ({ page }) => {
    test.setTimeout(180_000);
    await page.goto(`${server.url}?volume=bucky&isovalue=100`);
    await complete(page);
    const picture = page.getByRole("application");
    const views: string[] = [];
    for (const key of ["", "1", "3"]) {
      if (key) await picture.press(key);
      await settled(page);
      views.push(new URL(page.url()).search);
    }
    // The camera that the page chose fits the window: it is not in the address.
    expect(views[0]).not.toContain("camera");
    expect(new Set(views).size).toBe(3);
    const twice = (shiftKey: boolean) =>
      page.evaluate((shift) => {
        for (let i = 0; i < 2; ++i) {
          const key = { key: "z", ctrlKey: true, shiftKey: shift, bubbles: true };
          document.querySelector("#view")?.dispatchEvent(new KeyboardEvent("keydown", key));
        }
      }, shiftKey);
    await twice(false);
    await expect.poll(() => new URL(page.url()).search).toBe(views[0]);
    await settled(page);
    expect(new URL(page.url()).search).toBe(views[0]);
    await twice(true);
    await expect.poll(() => new URL(page.url()).search).toBe(views[2]);
    await settled(page);
    expect(new URL(page.url()).search).toBe(views[2]);
  });
});
