// Files of this device in Firefox: built in the page, kept, reopened, removed.
import { readFileSync } from "node:fs";
import { join } from "node:path";
import type { ElementHandle, Page } from "puppeteer-core";
import { afterAll, afterEach, beforeAll, beforeEach, expect, test } from "vitest";
import { loadCore } from "../../web/core/index.ts";
import { demoFolder, type RunningServer, serve } from "../browser/support/server.ts";
import { zipOf } from "../support/zip_files.ts";
import { type Firefox, startFirefox } from "./support/firefox.ts";
import { complete, parameter, shows } from "./support/view.ts";

let firefox: Firefox;
let server: RunningServer;
let page: Page;
/** The address of the program's store of bucky.nrrd, if it is on this device. */
let programStore: string;
beforeAll(async () => {
  server = await serve([demoFolder]);
  firefox = await startFirefox();
  const core = await loadCore();
  const store = core.openStore(readFileSync(join(demoFolder, "bucky.isosplat")));
  programStore = `device:${store.info.contentId}`;
  store.close();
});
afterAll(async () => {
  await firefox?.close();
  await server?.stop();
});
beforeEach(async () => {
  page = await firefox.browser.newPage();
  await page.goto(server.url);
  await page.waitForSelector(".device-drop");
});
afterEach(() => page.close());

/** Waits until the store is built and kept: then the card with the progress disappears. */
async function kept(): Promise<void> {
  await complete(page);
  await page.waitForFunction(() => document.querySelector(".task-card") === null);
}

test("a chosen volume is built, kept, reopened, and removed", async () => {
  const chooser = await page.waitForSelector("input[type=file]:not([webkitdirectory])");
  await (chooser as ElementHandle<HTMLInputElement>).uploadFile(join(demoFolder, "bucky.nrrd"));
  await kept();
  await shows(page, ".status-samples", /^[1-9].* samples$/);
  expect(await parameter(page, "src")).toBe(programStore);

  await page.reload();
  await complete(page);
  await shows(page, ".volume-name", /^bucky$/);
  expect(await parameter(page, "src")).toBe(programStore);

  await page.goto(server.url);
  await shows(page, ".device-card", /bucky.*128 × 128 × 128/s);
  await shows(page, ".device h2", /^On this device/);
  await page.locator("[aria-label='Remove bucky from this device']").click();
  await page.locator(".device-ask .chip").click(); // the first one: Remove
  await page.waitForFunction(() => document.querySelector(".device-card") === null);
  await page.goto(`${server.url}?src=${programStore}`);
  await shows(page, "[role=alert]", /open its file again/);
});

test("a dropped ZIP opens, and nothing is sent to another origin afterwards", async () => {
  const content = readFileSync(join(demoFolder, "bucky.nrrd"));
  const zip = zipOf([{ name: "scan/bucky.nrrd", content }]);
  await page.evaluate(async (data) => {
    const zipped = await (await fetch(`data:application/zip;base64,${data}`)).blob();
    const dataTransfer = new DataTransfer();
    dataTransfer.items.add(new File([zipped], "scan.zip"));
    document.body.dispatchEvent(new DragEvent("drop", { dataTransfer, bubbles: true }));
  }, Buffer.from(zip).toString("base64"));
  await kept();
  expect(await parameter(page, "src")).toBe(programStore);
  const refused = await page.evaluate(async () => {
    const blocked = new Promise<string>((resolve) =>
      document.addEventListener("securitypolicyviolation", (event) =>
        resolve(event.effectiveDirective),
      ),
    );
    await fetch("http://127.0.0.2:9/", { method: "POST", body: "voxels" }).catch(() => {});
    return blocked;
  });
  expect(refused).toBe("connect-src");
});
