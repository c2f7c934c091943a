/** A static site from `isosplat publish`, on nginx: no program of Isosplat answers its requests. */
import { execFileSync } from "node:child_process";
import { mkdirSync, mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { expect, test } from "@playwright/test";
import { hasNginx, type Nginx, nginx } from "../support/nginx.ts";
import { ballIsovalue, buildBall } from "../support/series.ts";
import { refusals } from "./support/policy.ts";
import { demoFolder, program } from "./support/server.ts";
import { complete } from "./support/view.ts";

test.skip(!hasNginx, "needs nginx");

let folder: string;
let host: Nginx;

test.beforeEach(async () => {
  folder = mkdtempSync(join(tmpdir(), "isosplat-site-"));
  const site = ["--to", join(folder, "site"), "--web-root", "build/page"];
  execFileSync(program, ["publish", demoFolder, ...site], { stdio: "ignore" });
  host = await nginx({ folders: [join(folder, "site")], cors: "none" });
});

test.afterEach(async () => {
  await host?.stop();
  rmSync(folder, { recursive: true, force: true });
});

/** Requests that nginx answered: path and status. */
const answers = async () =>
  (await host.accessLog()).map((line) => /"GET (\S+) [^"]*" (\d+)/.exec(line)?.slice(1) ?? []);

test("the page lists the volumes of the site, and opens them by byte ranges", async ({ page }) => {
  const refused = refusals(page);
  await page.goto(host.url);
  // This host sends no policy, so the page itself states one.
  await expect(page.locator("meta[http-equiv=Content-Security-Policy]")).toHaveCount(1);
  await expect(page.locator("a.card")).toHaveCount(3);
  const bucky = page.getByRole("link", { name: /bucky/i });
  await expect(bucky).toContainText("128 × 128 × 128");
  await expect(bucky.locator("img")).toBeVisible({ timeout: 30_000 });
  await bucky.click();
  await complete(page);
  await expect(page).toHaveURL(/volume=bucky.*isovalue=/);
  const found = await answers();
  expect(found.filter(([path]) => path?.startsWith("/v1"))).toEqual([]);
  const ofStores = found.filter(([path]) => /^\/stores\/.*\.isosplat$/.test(path ?? ""));
  expect(ofStores.length).toBeGreaterThan(3);
  // 304: the browser asks whether its copy is current, since this nginx sends no Cache-Control.
  expect(ofStores.filter(([, status]) => status !== "206" && status !== "304")).toEqual([]);
  expect(refused).toEqual([]);
});

test("a scene of the site is listed, and only byte ranges of its bundle are read", async ({
  page,
}) => {
  const balls = join(folder, "balls");
  mkdirSync(balls);
  for (const [name, x] of [
    ["left", 0.3],
    ["right", 0.7],
  ] as const) {
    buildBall(balls, name, 72, { centre: [x, 0.5, 0.5], radius: 0.2 });
  }
  const surfaces = [{ isovalue: ballIsovalue }];
  const layers = ["left", "right"].map((name) => ({ store: `${name}.isosplat`, surfaces }));
  const scene = { format: "isosplat-scene", version: 1, name: "Two balls", layers };
  writeFileSync(join(balls, "scene.json"), JSON.stringify(scene));
  const site = ["--to", join(folder, "site"), "--web-root", "build/page"];
  execFileSync(program, ["publish", demoFolder, balls, ...site], { stdio: "ignore" });
  const ranges: string[] = [];
  page.on("request", (request) => {
    if (request.url().endsWith(".isobundle")) ranges.push(request.headers().range ?? "all of it");
  });
  await page.goto(host.url);
  await page.locator(".scene-list a.card", { hasText: "Two balls" }).click();
  await expect(page).toHaveURL(/scene=balls~scene/);
  await expect(page).toHaveTitle("Two balls · Isosplat");
  await complete(page);
  const found = await answers();
  const ofBundle = found.filter(([path]) => /^\/stores\/.*\.isobundle$/.test(path ?? ""));
  expect(ofBundle.length).toBeGreaterThan(1);
  expect(ranges[0]).toBe("bytes=0-65535");
  expect(ofBundle.filter(([, status]) => status !== "206" && status !== "304")).toEqual([]);
  expect(found.filter(([path]) => path?.endsWith(".isosplat"))).toEqual([]);
});

test("a volume that the site does not have", async ({ page }) => {
  await page.goto(`${host.url}?volume=nothing`);
  await expect(page.getByRole("alert")).toContainText("No such volume");
  await expect(page.getByRole("alert")).toContainText("bucky");
});
