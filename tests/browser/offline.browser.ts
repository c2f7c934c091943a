// The page without a network: it opens, and shows volumes on this device and volumes that were viewed before.
// Also updates from one version of the page to the next.
import { execFileSync } from "node:child_process";
import { cpSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { expect, type Page, test } from "@playwright/test";
import { hasNginx, nginx } from "../support/nginx.ts";
import { demoFolder, program, type RunningServer, serve } from "./support/server.ts";
import { complete, settled } from "./support/view.ts";

test.use({ serviceWorkers: "allow" });

let server: RunningServer;
let folder: string;

test.beforeEach(async () => {
  folder = mkdtempSync(join(tmpdir(), "isosplat-offline-"));
  cpSync("build/page", join(folder, "page"), { recursive: true });
  server = await serve([demoFolder], 0, ["--web-root", join(folder, "page")]);
});
test.afterEach(async () => {
  await server.stop();
  rmSync(folder, { recursive: true, force: true });
});

/** Waits until the service worker is active and has kept the files of the first visit. */
async function kept(page: Page, cache: RegExp): Promise<void> {
  await expect
    .poll(
      () =>
        page.evaluate(async () => {
          const names = await caches.keys();
          const sizes = names.map(async (name) => {
            const { length } = await (await caches.open(name)).keys();
            return length > 0 ? [name] : [];
          });
          return (await Promise.all(sizes)).flat().join(" ");
        }),
      { timeout: 40_000 },
    )
    .toMatch(cache);
}

async function withoutNetwork(page: Page): Promise<void> {
  await server.stop();
  await page.context().setOffline(true);
}

test("the list and a volume that was viewed before are shown again", async ({ page }) => {
  const address = `${server.url}?volume=bucky&isovalue=100`;
  await page.goto(address);
  await complete(page);
  await settled(page);
  await kept(page, /isosplat-page-.*isosplat-seen-|isosplat-seen-.*isosplat-page-/);
  // The second visit requests the list, and all of its requests pass through the service worker.
  await page.goto(server.url);
  await expect(page.locator("a.card")).toHaveCount(3);
  await kept(page, /isosplat-lists/);
  await page.goto(address);
  await complete(page);
  await withoutNetwork(page);
  await page.goto(address);
  await complete(page);
  await page.goto(server.url);
  await expect(page.locator("a.card")).toHaveCount(3);
  await expect(page.getByText("Without a connection")).toBeVisible();
  expect(await keptLanguages(page)).toEqual([]);
});

/** The kept files of languages other than English. */
const keptLanguages = (page: Page): Promise<string[]> =>
  page.evaluate(async () => {
    const names = (await caches.keys()).filter((name) => name.startsWith("isosplat-page-"));
    const lists = names.map(async (name) => (await caches.open(name)).keys());
    const addresses = (await Promise.all(lists)).flat().map(({ url }) => url);
    return addresses.filter((address) => /\/de-[\w-]{8}\.js$/.test(address));
  });

test.describe("a German browser", () => {
  test.use({ locale: "de-DE" });

  test("has the page in German", async ({ page }) => {
    await page.goto(server.url);
    await kept(page, /isosplat-page-/);
    await expect.poll(async () => (await keptLanguages(page)).length).toBe(2);
    await withoutNetwork(page);
    await page.reload();
    await expect(page.getByRole("heading", { level: 1 })).toHaveText("Volumen");
    await expect(page.locator("html")).toHaveAttribute("lang", "de");
  });
});

test("volumes of this device are built and opened", async ({ page }) => {
  await page.goto(server.url);
  await kept(page, /isosplat-page-/);
  await withoutNetwork(page);
  await page.reload();
  await page.locator("input[type=file]").first().setInputFiles(`${demoFolder}/marschner_lobb.nrrd`);
  await complete(page);
  await expect(page).toHaveURL(/src=device%3A/);
  await page.reload();
  await complete(page);
});

test("a volume of a site that was viewed before is shown again", { tag: "@slow" }, async ({
  page,
}) => {
  test.skip(!hasNginx, "needs nginx");
  const site = join(folder, "site");
  execFileSync(program, ["publish", demoFolder, "--to", site, "--web-root", "build/page"], {
    stdio: "ignore",
  });
  const host = await nginx({ folders: [site], cors: "none" });
  const address = `${host.url}?volume=bucky&isovalue=100`;
  await page.goto(address);
  await complete(page);
  await settled(page);
  await kept(page, /isosplat-page-/);
  await page.goto(address);
  await complete(page);
  await kept(page, /isosplat-seen-/);
  await host.stop();
  await page.context().setOffline(true);
  await page.goto(address);
  await complete(page);
});

test("nothing of a volume that needs a token is kept", async ({ page }) => {
  await server.stop();
  const tokens = join(folder, "tokens");
  writeFileSync(tokens, "0123456789abcdef0123456789abcdef *\n", { mode: 0o600 });
  const more = ["--web-root", join(folder, "page"), "--token-file", tokens];
  server = await serve([demoFolder], 0, more);
  await page.goto(`${server.url}?token=0123456789abcdef0123456789abcdef`);
  await expect(page.locator("a.card")).toHaveCount(3);
  await kept(page, /isosplat-page-/);
  await page.goto(`${server.url}?volume=bucky`);
  await complete(page);
  const names = await page.evaluate(() => caches.keys());
  expect(names.filter((name) => !name.startsWith("isosplat-page-"))).toEqual([]);
});

test("a new version is announced, and used when the visitor requests it", { tag: "@slow" }, async ({
  page,
}) => {
  await page.goto(`${server.url}?volume=bucky`);
  await complete(page);
  await kept(page, /isosplat-page-/);
  await page.reload();
  await complete(page);
  const script = join(folder, "page", "service-worker.js");
  const version = /version:[`"']([0-9a-f]{16})/.exec(readFileSync(script, "utf8"))?.[1] ?? "";
  expect(version).not.toBe("");
  for (const end of ["", ".br"]) rmSync(`${script}${end}`, { force: true });
  const next = readFileSync("build/page/service-worker.js", "utf8").replaceAll(
    version,
    "f".repeat(16),
  );
  writeFileSync(script, next);
  let loads = 0;
  page.on("load", () => ++loads);
  await expect
    .poll(
      () =>
        page.evaluate(async () => {
          await (await navigator.serviceWorker.ready).update();
          return document.querySelector(".update-notice") !== null;
        }),
      { timeout: 40_000 },
    )
    .toBe(true);
  // Nothing is reloaded before the visitor requests it.
  expect(loads).toBe(0);
  await Promise.all([
    page.waitForEvent("load"),
    page.getByRole("button", { name: "Reload", exact: true }).click(),
  ]);
  await complete(page);
  await expect(page.locator(".update-notice")).toHaveCount(0);
});

test("files that another app shares are opened", async ({ page }) => {
  await page.goto(server.url);
  await kept(page, /isosplat-page-/);
  const file = readFileSync(`${demoFolder}/marschner_lobb.nrrd`).toString("base64");
  // Like the system, sends a form that does not come from a page of this site.
  await page.goto("about:blank");
  await page.evaluate(
    ([address, base64]) => {
      const form = document.createElement("form");
      form.method = "POST";
      form.enctype = "multipart/form-data";
      form.action = `${address}share`;
      const input = document.createElement("input");
      input.type = "file";
      input.name = "files";
      const bytes = Uint8Array.from(atob(base64 ?? ""), (c) => c.charCodeAt(0));
      const data = new DataTransfer();
      data.items.add(new File([bytes], "shared.nrrd"));
      input.files = data.files;
      form.append(input);
      document.body.append(form);
      form.submit();
    },
    [server.url, file],
  );
  await complete(page);
  await expect(page).toHaveURL(/src=device%3A/);
});
