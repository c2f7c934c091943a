/** Pictures that `isosplat build` made, in the list of volumes. */
import { execFileSync } from "node:child_process";
import { copyFileSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { expect, type Page, test } from "@playwright/test";
import { hasNginx, nginx } from "../support/nginx.ts";
import { demoFolder, program, serve } from "./support/server.ts";

const store = join(demoFolder, "bucky.isosplat");
let folder: string;

test.beforeEach(() => {
  folder = mkdtempSync(join(tmpdir(), "isosplat-thumbnails-"));
  copyFileSync(store, join(folder, "bucky.isosplat"));
});

test.afterEach(() => rmSync(folder, { recursive: true, force: true }));

/** The card's picture: its origin, and its width in pixels once it is loaded. */
const picture = (page: Page) =>
  page.locator("a.card img").evaluate((image: HTMLImageElement) => ({
    from: image.src.slice(0, 5) === "data:" ? "this browser" : new URL(image.src).pathname,
    width: image.naturalWidth,
  }));

test("the server's picture is shown at once, and the browser draws none", async ({ page }) => {
  copyFileSync(`${store}.webp`, join(folder, "bucky.isosplat.webp"));
  const server = await serve([folder]);
  const requests: string[] = [];
  page.on("request", (request) => requests.push(new URL(request.url()).pathname));
  try {
    await page.goto(server.url);
    await expect(async () => expect((await picture(page)).width).toBe(480)).toPass();
    expect((await picture(page)).from).toMatch(
      /^\/v1\/volumes\/bucky\/[0-9a-f]{32}\/thumbnail\.webp$/,
    );
    expect(requests.filter((path) => /bootstrap|chunks|batch|file$/.test(path))).toEqual([]);
  } finally {
    await server.stop();
  }
});

test("a damaged picture is replaced by one that the browser draws", async ({ page }) => {
  const webp = readFileSync(`${store}.webp`);
  writeFileSync(join(folder, "bucky.isosplat.webp"), webp.subarray(0, webp.length / 2));
  const server = await serve([folder]);
  try {
    await page.goto(server.url);
    await expect(async () => {
      const { from, width } = await picture(page);
      expect(from).toBe("this browser");
      expect(width).toBe(360);
    }).toPass({ timeout: 60_000 });
  } finally {
    await server.stop();
  }
});

test("a published site has the pictures of its stores", async ({ page }) => {
  test.skip(!hasNginx, "needs nginx");
  copyFileSync(`${store}.webp`, join(folder, "bucky.isosplat.webp"));
  const site = join(folder, "site");
  const options = ["--to", site, "--web-root", "build/page"];
  execFileSync(program, ["publish", join(folder, "bucky.isosplat"), ...options]);
  const host = await nginx({ folders: [site], cors: "none" });
  try {
    await page.goto(host.url);
    await expect(async () => expect((await picture(page)).width).toBe(480)).toPass();
    expect((await picture(page)).from).toMatch(/^\/stores\/bucky-[0-9a-f]{32}-[0-9a-f]{32}\.webp$/);
  } finally {
    await host.stop();
  }
});
