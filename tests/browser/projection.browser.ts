// The orthographic camera in the page: keys, panel, link, gestures, and the native picture.
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

/** Where the camera looks, and how far away it is. */
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
  // World units per CSS pixel, and from the middle of the picture to the pointer.
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
