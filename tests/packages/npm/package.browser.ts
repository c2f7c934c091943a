// The npm package in Chromium: installed from the tarball into an empty folder, then as plain files
// on a static server, and built by Vite. The pages are the README's examples.
import { join } from "node:path";
import { expect, type Page, test } from "@playwright/test";
import { build, createServer } from "vite";
import { decodePng } from "../../browser/support/pixels.ts";
import { freePort, type Nginx, nginx } from "../../support/nginx.ts";
import { type Consumer, consumer } from "./consumer.ts";

let project: Consumer;
let plain: Nginx;
let built: Nginx;

test.beforeAll(async () => {
  test.setTimeout(180_000);
  project = consumer();
  const output = join(project.folder, "dist");
  await build({
    root: project.folder,
    configFile: false,
    logLevel: "warn",
    build: {
      outDir: output,
      rolldownOptions: { input: ["index.html", "own.html"].map((f) => join(project.folder, f)) },
    },
  });
  plain = await nginx({ folders: [project.folder] });
  // The store lies beside the pages.
  built = await nginx({ folders: [output, project.folder] });
});

test.afterAll(async () => {
  await plain?.stop();
  await built?.stop();
  project?.remove();
});

interface Coverage {
  /** The share of the canvas's pixels that are not as its corner. */
  share: number;
  /** Whether the pixel in its middle is one of them. */
  middle: boolean;
}

async function coverage(page: Page): Promise<Coverage> {
  const png = await page.locator("canvas").screenshot();
  const { width, height, rgba } = await decodePng(page, png);
  const isCovered = (pixel: number): boolean =>
    [0, 1, 2].some((c) => Math.abs((rgba[4 * pixel + c] ?? 0) - (rgba[c] ?? 0)) > 12);
  let count = 0;
  for (let pixel = 0; pixel < width * height; ++pixel) if (isCovered(pixel)) ++count;
  const middle = Math.floor(height / 2) * width + Math.floor(width / 2);
  return { share: count / (width * height), middle: isCovered(middle) };
}

const covered = async (page: Page): Promise<number> => (await coverage(page)).share;

function complaints(page: Page): string[] {
  const found: string[] = [];
  page.on("console", (message) => {
    if (message.type() === "error" && !message.location().url.endsWith("/favicon.ico")) {
      found.push(message.text());
    }
  });
  page.on("pageerror", (error) => found.push(error.message));
  return found;
}

for (const file of ["plain.html", "element.html"]) {
  test(`example 3: ${file} on a static server`, async ({ page }) => {
    const found = complaints(page);
    await page.goto(`${plain.url}${file}`);
    await expect.poll(() => covered(page)).toBeGreaterThan(0.05);
    expect(found).toEqual([]);
  });
}

test("example 4: a user interface, built by Vite", async ({ page }) => {
  const found = complaints(page);
  await page.goto(`${built.url}index.html`);
  await expect(page.locator("output")).toHaveText("complete");
  const slider = page.locator("#isovalue");
  // The range of the store: quantized values from 0, less 100.
  expect(await slider.getAttribute("min")).toBe("-100");

  await slider.fill("60.5");
  await expect.poll(() => covered(page)).toBeGreaterThan(0.05);
  await expect(page.locator("output")).toHaveText("complete");
  const large = await covered(page);
  await slider.fill("400.5");
  await expect.poll(() => covered(page)).toBeLessThan(0.6 * large);

  await slider.fill("60.5");
  await expect.poll(() => covered(page)).toBeGreaterThan(0.9 * large);
  expect((await coverage(page)).middle).toBe(true);
  // The volume's top and bottom cut the ball open, so a view from above or below passes through it.
  await page.getByRole("button", { name: "From above" }).click();
  await expect.poll(async () => (await coverage(page)).middle).toBe(false);
  await expect.poll(() => covered(page)).toBeGreaterThan(0.03);
  expect(found).toEqual([]);
});

test("example 4 again, on Vite's development server", async ({ page }) => {
  const found = complaints(page);
  const server = await createServer({
    root: project.folder,
    configFile: false,
    logLevel: "warn",
    server: { host: "127.0.0.1", port: await freePort(), strictPort: true, hmr: false },
  });
  try {
    await server.listen();
    await page.goto(server.resolvedUrls?.local[0] ?? "");
    await expect(page.locator("output")).toHaveText("complete");
    expect(found).toEqual([]);
  } finally {
    await server.close();
  }
});

test("example 5: a renderer of one's own, built by Vite", async ({ page }) => {
  const found = complaints(page);
  await page.goto(`${built.url}own.html`);
  await expect(page).toHaveTitle("complete");
  await expect.poll(() => covered(page)).toBeGreaterThan(0.05);
  expect(found).toEqual([]);
});
