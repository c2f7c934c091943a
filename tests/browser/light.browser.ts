// The light in the page: the key light follows the ball, the keys and a drag on the picture; its
// settings are in the address, and give the native renderer's picture.
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

test.use({ viewport: { width: 800, height: 500 } });

const ball = (page: Page) => page.getByRole("slider", { name: "Direction of the key light" });

async function parameter(page: Page, name: string): Promise<string | null> {
  await settled(page);
  return new URL(page.url()).searchParams.get(name);
}

/** Drags from a position by this many pixels. */
async function drag(page: Page, x: number, y: number, dx: number, dy: number): Promise<void> {
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x + dx / 2, y + dy / 2);
  await page.mouse.move(x + dx, y + dy);
  await page.mouse.up();
}

test("the key light follows the ball and the arrow keys, and the address keeps it", {
  tag: "@slow",
}, async ({ page }) => {
  // A fixed kind of splats, because the pictures are compared pixel by pixel.
  await page.goto(`${server.url}?volume=bucky&isovalue=100&kind=exact`);
  await complete(page);
  await settled(page);
  const before = await savedPicture(page);
  await openSection(page, "Light");
  await expect(ball(page)).toHaveAttribute("aria-valuetext", "45° from the left, 45° from above");
  await ball(page).scrollIntoViewIfNeeded();
  const box = await ball(page).boundingBox();
  if (!box) throw new Error("no ball");
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  await drag(page, x, y, box.width / 4, box.height / 4);
  await expect(ball(page)).toHaveAttribute("aria-valuetext", /from the right, \d+° from below/);
  const [azimuth = 0, elevation = 0] = ((await parameter(page, "light")) ?? "")
    .split(",")
    .map(Number);
  expect(azimuth).toBeGreaterThan(25); // asin(½ / cos 30°) = 35°
  expect(azimuth).toBeLessThan(45);
  expect(elevation).toBeGreaterThan(-40); // −asin ½ = −30°
  expect(elevation).toBeLessThan(-20);

  await ball(page).press("ArrowUp");
  await ball(page).press("ArrowLeft");
  expect(await parameter(page, "light")).toBe(`${azimuth - 5},${elevation + 5}`);
  const turned = await savedPicture(page);
  expect((await compare(page, before, turned)).differing).toBeGreaterThan(0.05);

  await page.reload();
  await complete(page);
  await settled(page);
  expect((await compare(page, turned, await savedPicture(page))).differing).toBe(0);
  await openSection(page, "Light");
  await page.getByRole("button", { name: "Reset the light" }).click();
  expect(await parameter(page, "light")).toBeNull();
  expect((await compare(page, before, await savedPicture(page))).differing).toBe(0);
});

test("a drag with L on the picture turns the key light, and not the view", async ({ page }) => {
  await page.goto(`${server.url}?volume=bucky&isovalue=100`);
  await complete(page);
  const camera = await parameter(page, "camera");
  const box = await page.getByRole("application").boundingBox();
  if (!box) throw new Error("no picture");
  await page.keyboard.down("l");
  await drag(page, box.x + box.width / 2, box.y + box.height / 2, 40, -10);
  await page.keyboard.up("l");
  const [azimuth = 0, elevation = 0] = ((await parameter(page, "light")) ?? "")
    .split(",")
    .map(Number);
  expect(azimuth).toBeGreaterThan(-45);
  expect(elevation).toBeGreaterThan(45);
  expect(await parameter(page, "camera")).toBe(camera);
});

test("each part of the light changes the picture, which is the native renderer's", {
  tag: "@slow",
}, async ({ page }) => {
  test.setTimeout(180_000);
  const camera = "40,25,330,63.5,63.5,63.5";
  const view = `volume=bucky&isovalue=100.5&camera=${camera}&kind=exact&background=ffffff`;
  const picture = async (light: Readonly<Record<string, string>>) => {
    const query = Object.entries(light).map(([name, value]) => `&${name}=${value}`);
    await page.goto(`${server.url}?${view}${query.join("")}`);
    await complete(page);
    await settled(page);
    return savedPicture(page);
  };
  const all: Record<string, string> = {
    ...{ light: "30,20", "light-strength": "0.8,1.5,1", material: "1,0.6" },
    ...{ occlusion: "0.5,0.1", shadow: "0.5,0.3", shade: "0.3" },
  };
  const byDefault = await picture({});
  const { width, height } = await compare(page, byDefault, byDefault);
  for (const light of [{} as typeof all, all]) {
    const ours = light === all ? await picture(light) : byDefault;
    const native = drawNatively(join(demoFolder, "bucky.isosplat"), {
      ...{ isovalue: 100.5, camera, kind: "exact", width, height, light },
    });
    expect((await compare(page, ours, native)).differing).toBeLessThan(0.002);
  }
  const off = ["light-strength=0", "light-strength=1,0", "light-strength=1,1,0", "material=0"];
  for (const part of [...off, "occlusion=0", "shadow=0", "shade=0"]) {
    const [name = "", value = ""] = part.split("=");
    const without = await picture({ [name]: value });
    expect((await compare(page, byDefault, without)).differing, part).toBeGreaterThan(0.002);
  }
});
