// The button that offers a link to other programs of the device.
import { expect, type Page, test } from "@playwright/test";
import { demoFolder, type RunningServer, serve } from "./support/server.ts";
import { settled } from "./support/view.ts";

let server: RunningServer;
test.beforeAll(async () => {
  server = await serve([demoFolder]);
});
test.afterAll(() => server.stop());

const copy = (page: Page) => page.getByRole("button", { name: "Copy a link to this view" });
const share = (page: Page) => page.getByRole("button", { name: "Share a link to this view" });

/** Opens a volume in a browser whose system shares links, or does not. Lists what is shared. */
async function open(page: Page, shares: "shares" | "cancels" | "refuses" | "cannot") {
  const shared: unknown[] = [];
  await page.exposeFunction("isosplatShared", (data: unknown) => shared.push(data));
  await page.addInitScript((how) => {
    const { isosplatShared } = globalThis as unknown as { isosplatShared(data: unknown): void };
    const value = async (data: unknown) => {
      if (how === "cancels") throw new DOMException("cancelled", "AbortError");
      if (how === "refuses") throw new DOMException("refused", "NotAllowedError");
      isosplatShared(data);
    };
    Object.defineProperty(navigator, "share", { value: how === "cannot" ? undefined : value });
  }, shares);
  await page.goto(`${server.url}?volume=bucky&isovalue=100`);
  await settled(page);
  return shared;
}

test("the address of the view is shared, with a note on what it needs", async ({ page }) => {
  const shared = await open(page, "shares");
  await expect(copy(page)).toBeVisible();
  await share(page).click();
  await expect.poll(() => shared).toEqual([{ title: "bucky", url: page.url() }]);
  await expect(page.locator(".toast")).toContainText("this computer only");
});

test("cancelling needs no message", async ({ page }) => {
  await open(page, "cancels");
  await share(page).click();
  await page.keyboard.press("]"); // a later event of the page
  await expect(page.locator(".toast")).toHaveCount(0);
});

test("a refusal names the other way", async ({ page }) => {
  await open(page, "refuses");
  await share(page).click();
  await expect(page.locator(".toast")).toContainText("copy it instead");
});

test("without such a system there is no button", async ({ page }) => {
  await open(page, "cannot");
  await expect(copy(page)).toBeVisible();
  await expect(share(page)).toHaveCount(0);
});

test("on a phone the button takes the place of the other", async ({ page }) => {
  await page.setViewportSize({ width: 390, height: 844 });
  await open(page, "shares");
  await expect(share(page)).toBeVisible();
  await expect(copy(page)).toBeHidden();
});
