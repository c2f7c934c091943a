// The isovalues that a store suggests, as small pictures.
import { expect, type Page, test } from "@playwright/test";
import { demoFolder, type RunningServer, serve } from "./support/server.ts";
import { complete, settled } from "./support/view.ts";

let server: RunningServer;
test.beforeAll(async () => {
  server = await serve([demoFolder]);
});
test.afterAll(() => server.stop());

/** The most that the pictures may fetch, in bytes. */
const mostBytes = 40 * 1024;

const choices = (page: Page) => page.getByRole("group", { name: "Suggested isovalues" });
const pictures = (page: Page) => choices(page).locator("img");

async function open(page: Page): Promise<void> {
  await page.goto(`${server.url}?volume=marschner_lobb`);
  await complete(page);
  await settled(page);
}

/** The share of a picture's pixels that a surface covers, and their mean colour. */
const drawn = (page: Page, index: number) =>
  pictures(page)
    .nth(index)
    .evaluate(async (image: HTMLImageElement) => {
      await image.decode();
      const canvas = new OffscreenCanvas(image.naturalWidth, image.naturalHeight);
      const context = canvas.getContext("2d");
      context?.drawImage(image, 0, 0);
      const { data } = context?.getImageData(0, 0, canvas.width, canvas.height) ?? { data: [] };
      let covered = 0;
      const sum = [0, 0, 0];
      for (let i = 0; i < data.length; i += 4) {
        if ((data[i + 3] ?? 0) < 128) continue;
        ++covered;
        for (let c = 0; c < 3; ++c) sum[c] = (sum[c] ?? 0) + (data[i + c] ?? 0);
      }
      return { covered: (4 * covered) / data.length, colour: sum.map((each) => each / covered) };
    });

test("pictures of the suggested isovalues are drawn once the view rests", async ({ page }) => {
  await open(page);
  await expect(choices(page).getByRole("button")).toHaveCount(4);
  // From now on, neither the picture changes, nor does the page call itself busy.
  const view = page.getByRole("application");
  await view.evaluate((canvas) => {
    const changes: (string | null)[] = [];
    new MutationObserver(() => changes.push(canvas.getAttribute("aria-busy"))).observe(canvas, {
      attributes: true,
      attributeFilter: ["aria-busy"],
    });
    Object.assign(globalThis, { changes });
  });
  await page.waitForFunction(() => performance.getEntriesByName("isosplat:kept").length > 0);
  let bytes = 0;
  page.on("response", async (response) => {
    if (response.url().includes("/v1/")) bytes += (await response.body()).length;
  });
  await expect(pictures(page)).toHaveCount(4, { timeout: 30_000 });
  expect(bytes).toBeLessThan(mostBytes);
  expect(await page.evaluate(() => (globalThis as unknown as { changes: [] }).changes)).toEqual([]);
  await expect(page.locator(".hidden-view")).toHaveCount(0);
  for (const index of [0, 1, 2, 3]) {
    const { covered, colour } = await drawn(page, index);
    expect(covered).toBeGreaterThan(0.1);
    // White: the page multiplies it by the colour of the surface.
    expect(Math.max(...colour) - Math.min(...colour)).toBeLessThan(12);
  }

  const second = choices(page).getByRole("button").nth(1);
  const name = await second.getAttribute("aria-label");
  await second.focus();
  await page.keyboard.press("Enter");
  await expect(page).toHaveURL(new RegExp(`isovalue=${name}(&|$)`));
  await expect(second).toHaveAttribute("aria-pressed", "true");
  await expect(choices(page).locator("[aria-pressed=true]")).toHaveCount(1);
  await expect(pictures(page)).toHaveCount(4);
});

test("a picture has the colour of the surface", async ({ page }) => {
  await page.goto(`${server.url}?volume=marschner_lobb&colour=4f86c6`);
  await complete(page);
  await expect(pictures(page).first()).toBeVisible({ timeout: 30_000 });
  await expect(choices(page).locator(".choice-surface").first()).toHaveCSS(
    "background-color",
    "rgb(79, 134, 198)",
  );
});

test("a change of the view interrupts the drawing, which continues at rest", async ({ page }) => {
  // Turns the view as soon as the drawing begins.
  await page.addInitScript(() => {
    let drawings = 0;
    new MutationObserver((records) => {
      for (const node of records.flatMap(({ addedNodes }) => [...addedNodes])) {
        if (!(node instanceof HTMLElement) || node.className !== "hidden-view") continue;
        Object.assign(globalThis, { drawings: ++drawings });
        const key = new KeyboardEvent("keydown", { key: "ArrowLeft", bubbles: true });
        if (drawings === 1) document.querySelector(".view")?.dispatchEvent(key);
      }
    }).observe(document, { childList: true, subtree: true });
  });
  await open(page);
  await expect(pictures(page)).toHaveCount(4, { timeout: 30_000 });
  expect(
    await page.evaluate(() => (globalThis as unknown as { drawings: number }).drawings),
  ).toBeGreaterThan(1);
  await expect(page).toHaveURL(/camera=/);
  await expect(page.locator(".hidden-view")).toHaveCount(0);
});

test("a browser that saves data shows the numbers alone", async ({ page }) => {
  await page.addInitScript(() => {
    const connection = { saveData: true, effectiveType: "4g" };
    Object.defineProperty(navigator, "connection", { get: () => connection });
  });
  await open(page);
  await expect(choices(page).getByRole("button")).toHaveCount(4);
  await expect(choices(page).locator(".choice-picture")).toHaveCount(0);
});

test("there is nothing to choose from a single isovalue", async ({ page }) => {
  await page.goto(`${server.url}?volume=bucky`);
  await complete(page);
  await expect(choices(page).getByRole("button")).toHaveCount(1);
  await expect(choices(page).locator(".choice-picture")).toHaveCount(0);
});

test.describe("on a phone", () => {
  test.use({ viewport: { width: 390, height: 844 } });
  test("pictures are drawn when the panel is opened", async ({ page }) => {
    await open(page);
    await expect(choices(page).locator(".choice-picture").first()).toBeHidden();
    await page.getByRole("button", { name: "More controls" }).click();
    await expect(pictures(page)).toHaveCount(4, { timeout: 30_000 });
    await expect(pictures(page).first()).toBeVisible();
  });
});
