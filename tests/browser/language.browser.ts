// The page in German: how its language is chosen, and its texts. English visitors load no German.
import { expect, type Page, test } from "@playwright/test";
import { findings } from "./support/accessibility.ts";
import { demoFolder, type RunningServer, serve } from "./support/server.ts";
import { openSection } from "./support/view.ts";

let server: RunningServer;
test.beforeAll(async () => {
  server = await serve([demoFolder]);
});
test.afterAll(() => server.stop());

/** The width of the page beyond the window's width, in CSS pixels. */
const overflow = (page: Page) =>
  page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth);

/** Texts that do not fit into their buttons, labels and headings. */
const cutTexts = (page: Page) =>
  page
    .locator(".panel :is(button, h2, label, .field-label, dt, wa-button):visible")
    .evaluateAll((elements) =>
      elements
        .filter(({ scrollWidth, clientWidth }) => clientWidth > 1 && scrollWidth > clientWidth + 1)
        .map(({ textContent }) => textContent?.trim()),
    );

test.describe("a German browser", () => {
  test.use({ locale: "de-AT" });

  test("has the start page, the panel and a dialog in German", async ({ page }) => {
    await page.goto(server.url);
    await expect(page.locator("html")).toHaveAttribute("lang", "de");
    await expect(page.getByRole("heading", { level: 1 })).toHaveText("Volumen");
    await expect(page.getByText("irgendwohin ziehen oder")).toBeVisible();
    await expect(page.getByRole("link", { name: /bucky/ }).first()).toContainText("Voxel");
    expect(await findings(page)).toEqual([]);
    await page.setViewportSize({ width: 320, height: 640 });
    expect(await overflow(page)).toBe(0);

    await page.setViewportSize({ width: 1280, height: 720 });
    await page.goto(`${server.url}?volume=bucky&isovalue=100.5`);
    await expect(page.locator(".status")).toHaveAttribute("data-state", "complete");
    await expect(page.locator(".status-state")).toContainText("vollständig");
    await expect(page.getByRole("textbox", { name: "Isowert" })).toHaveValue("100,5");
    for (const name of ["Aussehen", "Licht", "Ansicht", "Messen", "Schnitt", "Über dieses Volumen"])
      await openSection(page, name);
    await expect(page.getByRole("button", { name: "Winkel" })).toBeVisible();
    expect(await cutTexts(page)).toEqual([]);
    expect(await findings(page)).toEqual([]);

    await page.getByRole("application").press("?");
    const dialog = page.getByRole("dialog", { name: "Tasten und Gesten" });
    await expect(page.getByText("Das Hauptlicht bewegen")).toBeVisible();
    await expect(dialog.getByRole("button", { name: "Schließen" })).toBeVisible();
    expect(await findings(page)).toEqual([]);
  });
});

test("a language from the address or chosen by hand is kept; English loads no German", async ({
  page,
}) => {
  const german: string[] = [];
  page.on("request", (request) => {
    if (/\/(de|de_default)-[^/]*\.js$/.test(request.url())) german.push(request.url());
  });
  const heading = page.getByRole("heading", { level: 1 });
  await page.goto(server.url);
  await expect(heading).toHaveText("Volumes");
  await page.goto(`${server.url}?volume=bucky`);
  await expect(page.locator(".status")).toHaveAttribute("data-state", "complete");
  expect(german).toEqual([]);

  await page.goto(`${server.url}?lang=de`);
  await expect(heading).toHaveText("Volumen");
  expect(german.length).toBeGreaterThan(0);
  await page.goto(server.url);
  await expect(heading).toHaveText("Volumen");

  await page.goto(`${server.url}?lang=de`);
  await page.getByLabel("Sprache").selectOption("English");
  await expect(heading).toHaveText("Volumes");
  await expect(page.locator("html")).toHaveAttribute("lang", "en");
  expect(new URL(page.url()).search).toBe("");
});

test("an element has the language of its attribute, or of the elements around it", async ({
  page,
}) => {
  await page.goto(`${server.url}embed.html`);
  const first = page.locator("isosplat-viewer").first();
  await expect(first.getByRole("button", { name: "Fit" })).toBeVisible();
  await first.evaluate((element) => element.setAttribute("show", "axes,clip"));
  await expect(first.getByRole("group", { name: "Orientation" })).toBeVisible();
  await first.evaluate((element) => element.setAttribute("lang", "de"));
  await expect(first.getByRole("button", { name: "Einpassen" })).toBeVisible();
  await expect(first.getByRole("group", { name: "Ausrichtung" })).toBeVisible();
  await expect(first.getByRole("slider", { name: /^Obere z-Seite/ })).toBeVisible();
  await first.evaluate((element) => {
    const around = document.createElement("div");
    around.lang = "en";
    element.before(around);
    element.removeAttribute("lang");
    around.append(element);
  });
  await expect(first.getByRole("button", { name: "Fit" })).toBeVisible();
});
