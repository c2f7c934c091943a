/** The page of a server that requires a token or a signed link. */
import { execFileSync } from "node:child_process";
import { copyFileSync, mkdirSync, mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { expect, test } from "@playwright/test";
import { demoFolder, program, type RunningServer, serve } from "./support/server.ts";
import { settled } from "./support/view.ts";

const token = "token-0123456789abcdef";
const folder = mkdtempSync(join(tmpdir(), "isosplat-access-"));
const keyFile = join(folder, "key");
let server: RunningServer;

test.beforeAll(async () => {
  writeFileSync(join(folder, "tokens"), `${token} bucky\n`);
  writeFileSync(keyFile, "k".repeat(64));
  server = await serve([demoFolder], 0, [
    ...["--token-file", join(folder, "tokens")],
    ...["--link-key-file", keyFile],
  ]);
});

test.afterAll(async () => {
  await server.stop();
  rmSync(folder, { recursive: true, force: true });
});

test("an address with a token opens the volume, and the token is removed from it", async ({
  page,
}) => {
  await page.goto(`${server.url}?token=${token}&volume=bucky`);
  await settled(page);
  await expect(page.getByRole("alert")).toHaveCount(0);
  expect(page.url()).not.toContain("token");
  expect(await page.evaluate("document.cookie"), "scripts cannot read the token").toBe("");
  // From now on, the cookie gives access to the same volumes, and to no others.
  await page.goto(server.url);
  await expect(page.locator("a.card")).toHaveCount(1);
  await page.goto(`${server.url}?volume=mandelbulb`);
  await expect(page.getByText("No such volume")).toBeVisible();
});

test("a signed link opens its volume", async ({ page }) => {
  const options = ["--link-key-file", keyFile, "--url", server.url];
  const link = execFileSync(program, ["sign-link", "bucky", ...options])
    .toString()
    .trim();
  await page.goto(link);
  await settled(page);
  await expect(page.getByRole("alert")).toHaveCount(0);
});

test("a signed link opens its scene, but not a volume of the same name", async ({ page }) => {
  const served = join(folder, "served");
  mkdirSync(served);
  copyFileSync("tests/golden/bundle1.0/golden.isobundle", join(served, "same.isobundle"));
  copyFileSync("tests/golden/v1.0/u8.isosplat", join(served, "same.isosplat"));
  const both = await serve([served], 0, ["--link-key-file", keyFile]);
  const options = ["--link-key-file", keyFile, "--url", both.url];
  const link = execFileSync(program, ["sign-link", "same", "--scene", ...options])
    .toString()
    .trim();
  expect(link).toContain("?scene=same&");
  await page.goto(link);
  await expect(page).toHaveTitle("Golden stores · Isosplat");
  await settled(page);
  await expect(page.getByRole("alert")).toHaveCount(0);
  await page.goto(link.replace("?scene=", "?volume="));
  await expect(page.getByText("No such volume")).toBeVisible();
  await both.stop();
});

test("without either, the page reports what is needed, and shows nothing", async ({ page }) => {
  await page.goto(server.url);
  await expect(page.getByText("This server needs a token")).toBeVisible();
  await expect(page.locator("a.card")).toHaveCount(0);
  await page.goto(`${server.url}?volume=bucky`);
  await expect(page.getByText("The server refuses access")).toBeVisible();
});
