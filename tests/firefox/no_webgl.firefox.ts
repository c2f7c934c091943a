// Firefox without WebGL 2, as on a machine without a display.
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

test("no WebGL 2: the page reports it, and shows the list of volumes", async () => {
  const page = await firefox.browser.newPage();
  await page.goto(`${server.url}?volume=bucky`);
  const isThere = await page.evaluate(
    () => document.createElement("canvas").getContext("webgl2") !== null,
  );
  expect(isThere).toBe(false);
  await shows(page, "[role=alert]", /no WebGL 2/);
  // There is no button for another attempt, because it could not succeed.
  expect(await page.$$("[role=alert] wa-button")).toHaveLength(0);
  // The list of volumes still works.
  await page.locator("a.brand").click();
  await page.waitForSelector("a.card[href*=bucky]");
});
