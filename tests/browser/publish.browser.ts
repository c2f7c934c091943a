/** A static site from `isosplat publish`, on nginx: no program of Isosplat answers its requests. */
import { execFileSync } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { expect, test } from "@playwright/test";
import { hasNginx, type Nginx, nginx } from "../support/nginx.ts";
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
const answers = () =>
  host.accessLog().map((line) => /"GET (\S+) [^"]*" (\d+)/.exec(line)?.slice(1) ?? []);

test("the page lists the volumes of the site, and opens them by ranges of bytes", async ({
  page,
}) => {
  const refused = refusals(page);
  await page.goto(host.url);
  // This host sends no policy: the page has its own.
  await expect(page.locator("meta[http-equiv=Content-Security-Policy]")).toHaveCount(1);
  await expect(page.locator("a.card")).toHaveCount(3);
  const bucky = page.getByRole("link", { name: /bucky/i });
  await expect(bucky).toContainText("128 × 128 × 128");
  await expect(bucky.locator("img")).toBeVisible({ timeout: 30_000 });
  await bucky.click();
  await complete(page);
  await expect(page).toHaveURL(/volume=bucky.*isovalue=/);
  const found = answers();
  expect(found.filter(([path]) => path?.startsWith("/v1"))).toEqual([]);
  const ofStores = found.filter(([path]) => /^\/stores\/.*\.isosplat$/.test(path ?? ""));
  expect(ofStores.length).toBeGreaterThan(3);
  // 304: the browser asks whether its copy is current, since this nginx sends no Cache-Control.
  expect(ofStores.filter(([, status]) => status !== "206" && status !== "304")).toEqual([]);
  expect(refused).toEqual([]);
});

test("a volume that the site does not have", async ({ page }) => {
  await page.goto(`${host.url}?volume=nothing`);
  await expect(page.getByRole("alert")).toContainText("No such volume");
  await expect(page.getByRole("alert")).toContainText("bucky");
});
