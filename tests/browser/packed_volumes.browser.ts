// Opens volumes in the page that another program has compressed as a whole. A worker decompresses
// each of them.
import { readFileSync } from "node:fs";
import { fileURLToPath } from "node:url";
import { gunzipSync, gzipSync } from "node:zlib";
import { expect, type Page, test } from "@playwright/test";
import { demoFolder, type RunningServer, serve } from "./support/server.ts";
import { complete } from "./support/view.ts";

const contentOf = (suffix: string): Buffer =>
  readFileSync(fileURLToPath(new URL(`packed/ball.nrrd.${suffix}`, import.meta.url)));

let server: RunningServer;
test.beforeAll(async () => {
  server = await serve([demoFolder]);
});
test.afterAll(() => server.stop());

async function choose(page: Page, suffix: string, buffer: Buffer): Promise<void> {
  await page.goto(server.url);
  const file = { name: `ball.nrrd.${suffix}`, mimeType: "application/octet-stream", buffer };
  await page.locator(".device-drop input").first().setInputFiles(file);
}

for (const suffix of ["gz", "bz2", "xz", "zst"]) {
  test(`a volume in ${suffix}`, async ({ page }) => {
    await choose(page, suffix, contentOf(suffix));
    await complete(page);
    await expect(page.locator(".volume-name")).toHaveText("ball");
  });
}

test("a volume in gz of two members", async ({ page }) => {
  const content = gunzipSync(contentOf("gz"));
  const members = [content.subarray(0, 5000), content.subarray(5000)].map((part) => gzipSync(part));
  await choose(page, "gz", Buffer.concat(members));
  await complete(page);
  await expect(page.locator(".volume-name")).toHaveText("ball");
});

for (const suffix of ["bz2", "xz", "zst"]) {
  test(`a volume in ${suffix} that was cut off is one error`, async ({ page }) => {
    const whole = contentOf(suffix);
    await choose(page, suffix, whole.subarray(0, whole.length - 200));
    await expect(page.locator(".task-card [role=alert]")).toContainText("copy or download");
  });
}
