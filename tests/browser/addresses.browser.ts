/**
 * Addresses. Invalid settings are ignored or limited, with a message. A copied address gives the
 * same picture.
 */
import { expect, type Page, test } from "@playwright/test";
import { demoFolder, type RunningServer, serve } from "./support/server.ts";
import { compare, complete, savedPicture, settled } from "./support/view.ts";

let server: RunningServer;
test.beforeAll(async () => {
  server = await serve([demoFolder]);
});
test.afterAll(() => server.stop());
test.use({ viewport: { width: 800, height: 500 } });

async function finalPicture(page: Page): Promise<Buffer> {
  await complete(page);
  await settled(page);
  return savedPicture(page);
}

for (const src of ["http://", "https://[", "javascript:alert(1)", "data:,x"]) {
  test(`?src=${src} is not the address of a store`, async ({ page }) => {
    await page.goto(`${server.url}?src=${encodeURIComponent(src)}`);
    const message = page.getByRole("alert");
    await expect(message).toContainText("not the address of a store");
    await expect(message.getByRole("button", { name: "Try again" })).toHaveCount(0);
    await expect(message.getByRole("link", { name: "All volumes" })).toBeVisible();
  });
}

test("?src=%, an invalid escape: the page reports an error", async ({ page }) => {
  await page.goto(`${server.url}?src=%`);
  await expect(page.getByRole("alert")).toBeVisible();
  await expect(page.locator(".volume-name")).toHaveText("%");
});

test("a camera, an isovalue and an opacity far out of range", async ({ page }) => {
  const view = "camera=1e20,2,1e25,1e30,0,0&isovalue=9999&opacity=0";
  await page.goto(`${server.url}?volume=bucky&${view}`);
  const note = page.locator(".toast");
  for (const text of ["invisible", "9999", "too far"]) await expect(note).toContainText(text);
  await complete(page);
  await expect(page.locator(".status-samples")).not.toHaveText("0 samples");
  await settled(page);
  const address = new URL(page.url()).searchParams;
  expect(Number(address.get("isovalue"))).toBeLessThan(247);
  const camera = address.get("camera")?.split(",").map(Number) ?? [];
  expect(Math.max(...camera.map(Math.abs))).toBeLessThan(1e5);
});

test("a view beside the volume is complete, and the page reports that it has no surface", async ({
  page,
}) => {
  await page.goto(`${server.url}?volume=bucky&isovalue=100&camera=0,0,100,5000,0,0`);
  await expect(page.locator(".status-state")).toHaveText("complete: no surface in this view");
  await settled(page);
});

for (const [where, camera] of [
  ["beside the volume", "0,0,100,5000,0,0"],
  ["far from the volume", "30,20,90000,63.5,63.5,63.5"],
  ["inside of the volume", "30,20,0.01,20,20,20"],
]) {
  test(`a camera ${where}, then reset: no message stays`, async ({ page }) => {
    await page.goto(`${server.url}?volume=bucky&isovalue=100&camera=${camera}&kind=ellipse`);
    await expect(page.locator(".status-state")).toHaveText(/^complete/);
    await settled(page);
    await page.getByRole("application").focus();
    await page.keyboard.press("r");
    const picture = await finalPicture(page);
    await expect(page.getByRole("alert")).toHaveCount(0);
    await expect(page.locator(".banner")).toHaveCount(0);
    await expect(page.locator("wa-spinner")).toHaveCount(0);
    await expect(page.locator(".toast")).toHaveCount(0);
    await page.goto(`${server.url}?volume=bucky&isovalue=100&kind=ellipse`);
    const { covered, differing } = await compare(page, await finalPicture(page), picture);
    expect(covered).toBeGreaterThan(0.05);
    expect(differing).toBe(0);
  });
}

test("the page reports that a part of its program did not load", async ({ page }) => {
  await page.route("**/assets/components-*.js", (route) => route.fulfill({ status: 404 }));
  await page.goto(`${server.url}?volume=bucky&isovalue=100`);
  const message = page.locator(".page-incomplete");
  await expect(message).toContainText("did not load");
  await complete(page);
  const header = await page.locator(".bar").boundingBox();
  const { y = 0 } = (await message.boundingBox()) ?? {};
  expect(y).toBeGreaterThan((header?.y ?? 0) + (header?.height ?? 0));
  await expect(message.getByRole("button", { name: "Reload" })).toHaveCSS("border-radius", "99px");
  await message.getByRole("button", { name: "Close" }).click();
  await expect(message).toHaveCount(0);
});

test("parts and styles that did not load are requested again", async ({ page }) => {
  const later = /assets\/(components|overlay|page_pick|device_files)-[^/]*\.(js|css)/;
  await page.route(later, (route) => route.abort());
  await page.goto(`${server.url}?volume=bucky&isovalue=100`);
  const message = page.locator(".page-incomplete");
  await expect(message).toBeVisible();
  await page.unroute(later);
  await expect(page.locator(".overlay-axes, .overlay")).not.toHaveCount(0);
  await expect(page.getByRole("button", { name: "Reset the view" })).toBeVisible();
  await expect(message).toHaveCount(0);
  // The style sheet of a part.
  await expect
    .poll(() =>
      page.evaluate(
        () => [...document.styleSheets].filter(({ href }) => href?.includes("device_files")).length,
      ),
    )
    .toBe(1);
});

test("the page reports that its program did not load", async ({ page }) => {
  await page.route("**/assets/index-*.js", (route) => route.fulfill({ status: 404 }));
  await page.goto(`${server.url}?volume=bucky`);
  const message = page.locator(".not-started");
  await expect(message).toBeHidden();
  // The message is in the HTML and appears by an animation, so the test shows it at once.
  await page.evaluate(() => {
    for (const animation of document.getAnimations()) animation.finish();
  });
  await expect(message).toBeVisible();
});

test("the address of a view gives the same picture, pixel by pixel", async ({ page, browser }) => {
  test.setTimeout(120_000);
  // The ripples of this volume are as thin as a pixel: any other camera gives other pixels.
  await page.goto(`${server.url}?volume=marschner_lobb&isovalue=134.5&kind=ellipse`);
  await complete(page);
  await page.getByRole("application").focus();
  for (const key of ["ArrowLeft", "ArrowUp", "+", "+", "-"]) await page.keyboard.press(key);
  const original = await finalPicture(page);
  const context = await browser.newContext({ viewport: { width: 800, height: 500 } });
  const copy = await context.newPage();
  await copy.goto(page.url());
  const { covered, differing } = await compare(page, await finalPicture(copy), original);
  await context.close();
  expect(covered).toBeGreaterThan(0.1);
  expect(differing).toBe(0);
});
