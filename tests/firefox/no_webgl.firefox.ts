// Firefox without WebGL 2, as it is without a display.
import { afterAll, beforeAll, expect, test } from "vitest";
import { demoFolder, type RunningServer, serve } from "../browser/support/server.ts";
import { type Firefox, startFirefox } from "./support/firefox.ts";
import { shows } from "./support/view.ts";

let firefox: Firefox;
let server: RunningServer;
beforeAll(async () => {
  server = await serve([demoFolder]);
  firefox = await startFirefox({ webgl: false });
});
afterAll(async () => {
  await firefox?.close();
  await server?.stop();
});

test("no WebGL 2: the page says so, and the list of volumes is there", async () => {
  const page = await firefox.browser.newPage();
  await page.goto(`${server.url}?volume=bucky`);
  const isThere = await page.evaluate(
    () => document.createElement("canvas").getContext("webgl2") !== null,
  );
  expect(isThere).toBe(false);
  await shows(page, "[role=alert]", /no WebGL 2/);
  // Trying again could not help.
  expect(await page.$$("[role=alert] wa-button")).toHaveLength(0);
  // Volumes can be looked through all the same.
  await page.locator("a.brand").click();
  await page.waitForSelector("a.card[href*=bucky]");
});
