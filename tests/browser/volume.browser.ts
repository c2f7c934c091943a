// One volume in the page, from the real server: opened, scrubbed, rotated, restored from its
// address, and compared with the native renderer's picture.
import { join } from "node:path";
import { expect, type Page, test } from "@playwright/test";
import { rendererName } from "./support/in_page.ts";
import { drawNatively } from "./support/native_picture.ts";
import { demoFolder, type RunningServer, serve } from "./support/server.ts";
import { compare, complete, openSection, savedPicture, settled } from "./support/view.ts";

let server: RunningServer;
test.beforeAll(async () => {
  server = await serve([demoFolder]);
});
test.afterAll(() => server.stop());

test.use({ viewport: { width: 1000, height: 600 } });

const isovalue = (page: Page) =>
  page.locator(".isovalue-slider").evaluate((slider) => (slider as HTMLInputElement).valueAsNumber);

/** Counts the requests for data from now on. */
function countRequests(page: Page): { count: () => number } {
  let count = 0;
  page.on("request", (request) => {
    if (request.url().includes("/v1/")) ++count;
  });
  return { count: () => count };
}

test("lists the volumes, and opens one", async ({ page }) => {
  await page.goto(server.url);
  const cards = page.locator("a.card");
  await expect(cards).toHaveCount(3);
  const bucky = page.getByRole("link", { name: /bucky/i });
  await expect(bucky).toContainText("128 × 128 × 128");
  await expect(bucky).toContainText("8 bit");
  // The page makes the card's picture of the surface automatically.
  await expect(bucky.locator("img")).toBeVisible({ timeout: 30_000 });
  await bucky.click();
  await complete(page);
  expect(await page.evaluate(rendererName)).toContain("llvmpipe");
  await expect(page).toHaveURL(/volume=bucky.*isovalue=/);
  await expect(page.locator(".status-samples")).toHaveText(/samples/);
  await expect(page.locator(".status-bytes")).toHaveText(/fetched/);
  await expect(page.locator(".status-level")).toHaveText(/full resolution|level/);
});

test("draws the native renderer's picture", async ({ page }) => {
  const camera = "40,25,330,63.5,63.5,63.5";
  const view = `isovalue=100.5&camera=${camera}&kind=ellipse&background=ffffff`;
  await page.goto(`${server.url}?volume=bucky&${view}`);
  await complete(page);
  await settled(page);
  const ours = await savedPicture(page);
  const { width, height } = await compare(page, ours, ours);

  const native = drawNatively(join(demoFolder, "bucky.isosplat"), {
    isovalue: 100.5,
    camera,
    kind: "ellipse",
    width,
    height,
  });
  const difference = await compare(page, ours, native);
  expect(difference.covered).toBeGreaterThan(0.1);
  expect(difference.differing).toBeLessThan(0.002);
});

test("a moved slider shows another surface, without a request if its chunks are resident", async ({
  page,
}) => {
  await page.goto(`${server.url}?volume=bucky&isovalue=100&kind=quad&background=ffffff`);
  await complete(page);
  await settled(page);
  const before = await savedPicture(page);
  const slider = page.locator(".isovalue-slider");
  const requests = countRequests(page);

  await slider.press("ArrowRight");
  await slider.press("ArrowRight");
  expect(await isovalue(page)).toBe(101);
  await settled(page);
  expect(requests.count()).toBe(0);
  const near = await compare(page, before, await savedPicture(page));
  expect(near.differing).toBeGreaterThan(0.001);

  // During a drag over the whole range there is always a surface, and there are few requests.
  const box = await page.locator("#histogram").boundingBox();
  if (!box) throw new Error("no histogram");
  await page.mouse.move(box.x + 0.1 * box.width, box.y + 30);
  await page.mouse.down();
  for (let step = 1; step <= 20; ++step) {
    await page.mouse.move(box.x + (0.1 + 0.035 * step) * box.width, box.y + 30);
    await page.waitForTimeout(25);
    const samples = await page.locator(".status-samples").textContent();
    expect(samples).not.toMatch(/^0 /);
  }
  await page.mouse.up();
  await settled(page);
  expect(await isovalue(page)).toBeGreaterThan(190);
  expect(requests.count()).toBeLessThan(30);
});

test("the address restores the whole view", async ({ page, context }) => {
  // A fixed kind: the automatic one depends on frame times, and edges differ between kinds.
  await page.goto(`${server.url}?volume=bucky&isovalue=90.5&kind=exact`);
  await complete(page);
  const canvas = page.getByRole("application");
  await canvas.focus();
  for (const key of ["ArrowLeft", "ArrowUp", "+", "+", "Shift+ArrowRight", "]"]) {
    await page.keyboard.press(key);
  }
  await settled(page);
  const url = page.url();
  expect(url).toContain("camera=");
  expect(url).not.toContain("isovalue=90.5");
  const picture = await savedPicture(page);

  const other = await context.newPage();
  await other.goto(url);
  await complete(other);
  await settled(other);
  expect(other.url()).toBe(url);
  const difference = await compare(other, picture, await savedPicture(other));
  expect(difference.covered).toBeGreaterThan(0.05);
  expect(difference.differing).toBeLessThan(0.001);
});

test("mouse and keys rotate, pan, zoom and reset the view", async ({ page }) => {
  await page.goto(`${server.url}?volume=bucky&isovalue=100`);
  await complete(page);
  const camera = async () => {
    await settled(page);
    const text = new URL(page.url()).searchParams.get("camera") ?? "";
    return text.split(",").map(Number);
  };
  const box = await page.getByRole("application").boundingBox();
  if (!box) throw new Error("no canvas");
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];

  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x + 60, y + 20, { steps: 3 });
  await page.mouse.up();
  const turned = await camera();
  expect(turned).toHaveLength(6);

  await page.mouse.wheel(0, -300);
  const zoomed = await camera();
  expect(zoomed[2]).toBeLessThan(0.9 * (turned[2] ?? 0));
  expect(zoomed[0]).toBeCloseTo(turned[0] ?? 0, 3);

  await page.mouse.down({ button: "right" });
  await page.mouse.move(x + 50, y, { steps: 2 });
  await page.mouse.up({ button: "right" });
  const moved = await camera();
  expect(moved[2]).toBeCloseTo(zoomed[2] ?? 0, 3);
  expect(moved.slice(3)).not.toEqual(zoomed.slice(3));

  await page.keyboard.press("r");
  await settled(page);
  // The address does not contain the whole view, because it depends on the window.
  expect(new URL(page.url()).searchParams.has("camera")).toBe(false);
  await page.keyboard.press("ArrowRight");
  expect((await camera())[2]).toBeGreaterThan(zoomed[2] ?? 0);
});

test("cuts across the view, and keeps the plane in the address", async ({ page }) => {
  await page.goto(`${server.url}?volume=bucky&isovalue=100&kind=quad&background=ffffff`);
  await complete(page);
  await settled(page);
  const whole = await savedPicture(page);
  await openSection(page, "Clipping");
  await page.getByRole("button", { name: "Cut across the view" }).click();
  await expect(page).toHaveURL(/&plane=-?[\d.]+,[\d.-]+,[\d.-]+,[\d.-]+/);
  await complete(page);
  await settled(page);
  const cut = await savedPicture(page);
  expect((await compare(page, whole, cut)).differing).toBeGreaterThan(0.02);

  // The plane can be moved by keyboard as well.
  const plane = page.locator("wa-slider[label=Plane] [role=slider]");
  const before = new URL(page.url()).searchParams.get("plane");
  await plane.press("ArrowRight");
  await expect.poll(() => new URL(page.url()).searchParams.get("plane")).not.toBe(before);
  await page.getByRole("button", { name: "Show the whole volume" }).click();
  await expect(page).not.toHaveURL(/plane=/);
  await complete(page);
  await settled(page);
  expect((await compare(page, whole, await savedPicture(page))).differing).toBeLessThan(0.002);
});

test("shows several surfaces and colours, and keeps them in the address", async ({ page }) => {
  await page.goto(`${server.url}?volume=bucky&isovalue=60.5`);
  await complete(page);
  await page.getByRole("button", { name: "Add a surface" }).click();
  await expect(page.locator(".surface")).toHaveCount(2);
  await expect(page).toHaveURL(/isovalue=60.5,[\d.]+&opacity=0.4,1/);
  await complete(page);

  await openSection(page, "Appearance");
  await page.getByRole("combobox", { name: "Colour" }).click();
  await page.getByRole("option", { name: "Gradient" }).click();
  await expect(page).toHaveURL(/colour-by=gradient/);

  await page.getByRole("button", { name: "Remove surface 2" }).click();
  await expect(page.locator(".surface")).toHaveCount(1);
});

test("a view at rest draws nothing", async ({ page }) => {
  await page.addInitScript(() => {
    const counted = window as unknown as { frames: number };
    counted.frames = 0;
    const request = window.requestAnimationFrame.bind(window);
    (window as unknown as { ownFrame: typeof request }).ownFrame = request;
    window.requestAnimationFrame = (callback) => {
      ++counted.frames;
      return request(callback);
    };
  });
  await page.goto(`${server.url}?volume=bucky&isovalue=100`);
  await complete(page);
  const frames = () => page.evaluate(() => (window as unknown as { frames: number }).frames);
  // Waits until the picture at rest has its final quality; then a hundred frames pass without
  // drawing.
  await settled(page);
  const before = await frames();
  await page.evaluate(async () => {
    const { ownFrame } = window as unknown as { ownFrame: typeof requestAnimationFrame };
    for (let i = 0; i < 100; ++i) await new Promise((next) => ownFrame(next));
  });
  expect((await frames()) - before).toBe(0);
});

test("recovers from a lost context", async ({ page }) => {
  await page.goto(`${server.url}?volume=bucky&isovalue=100&background=ffffff&kind=ellipse`);
  await complete(page);
  await settled(page);
  const before = await savedPicture(page);
  await page.evaluate(async () => {
    const canvas = document.querySelector<HTMLCanvasElement>("#view");
    const extension = canvas?.getContext("webgl2")?.getExtension("WEBGL_lose_context");
    const heard = (name: string) =>
      new Promise((resolve) => canvas?.addEventListener(name, resolve, { once: true }));
    const lost = heard("webglcontextlost");
    extension?.loseContext();
    await lost;
    // The browser ignores calls from within its event.
    await new Promise((resolve) => setTimeout(resolve));
    const restored = heard("webglcontextrestored");
    extension?.restoreContext();
    await restored;
  });
  await settled(page);
  await complete(page);
  const difference = await compare(page, before, await savedPicture(page));
  expect(difference.covered).toBeGreaterThan(0.05);
  expect(difference.differing).toBeLessThan(0.001);
});
