// The page's list of layers: several volumes in one picture, in list, link and undo.
import { readFileSync } from "node:fs";
import { expect, type Locator, type Page, test } from "@playwright/test";
import { findings } from "./support/accessibility.ts";
import { demoFolder, type RunningServer, serve } from "./support/server.ts";
import { complete, openSection, settled } from "./support/view.ts";

let server: RunningServer;
test.beforeAll(async () => {
  server = await serve([demoFolder]);
});
test.afterAll(() => server.stop());

const look = "kind=exact&shading=exact";
const two = `volume=bucky&isovalue=100&${look}&layer=volume:marschner_lobb;name:Waves;isovalue:128;colour:c8553d`;

async function open(page: Page, query: string): Promise<void> {
  await page.goto(`${server.url}?${query}`);
  await complete(page);
  await settled(page);
}

/** The names in the list, from top to bottom. */
const names = (page: Page): Locator => page.locator(".layer-name");
const parameters = async (page: Page, name = "layer") => {
  await settled(page);
  return new URL(page.url()).searchParams.getAll(name);
};
const row = (page: Page, name: string) => page.locator(".layer-row").filter({ hasText: name });

test("one volume looks as before; a second one is added from the server's list", async ({
  page,
}) => {
  await open(page, `volume=bucky&isovalue=100&${look}`);
  await expect(page.locator(".layer-list")).toHaveCount(0);
  await expect(page.locator(".isovalue-layer")).toHaveCount(0);
  await openSection(page, "Layers");
  await expect(names(page)).toHaveText(["bucky"]);
  await page.getByRole("button", { name: "Add a volume" }).click();
  await expect(page.getByRole("button", { name: /marschner_lobb/ })).toBeVisible();
  expect(await findings(page)).toEqual([]);
  await page.getByRole("button", { name: /marschner_lobb/ }).click();
  await expect(names(page)).toHaveText(["bucky", "marschner_lobb"]);
  // The new layer is chosen: its isovalue and its histogram are shown. It has a different colour.
  await expect(page.locator(".isovalue-layer")).toHaveText("marschner_lobb");
  await expect(page.locator(".histogram-ends")).toContainText("255");
  await complete(page);
  await settled(page);
  expect(await parameters(page)).toEqual([
    expect.stringMatching(/^volume:marschner_lobb;isovalue:[\d.]+;colour:c8553d$/),
  ]);
  expect(await findings(page)).toEqual([]);
});

test("isovalue, surfaces and their cost belong to the chosen layer", async ({ page }) => {
  await open(page, two);
  const field = page.getByRole("textbox", { name: "Isovalue" });
  await expect(field).toHaveValue("100");
  const cost = page.locator(".isovalue-cost");
  await expect(cost).toContainText("at full detail");
  const ofFirst = await cost.textContent();
  await names(page).nth(1).click();
  await expect(field).toHaveValue("128");
  await expect(cost).toContainText("at full detail");
  expect(await cost.textContent()).not.toBe(ofFirst);
  await field.fill("140");
  await field.press("Enter");
  await page.getByRole("button", { name: "Add a surface" }).click();
  await complete(page);
  const [layer = ""] = await parameters(page);
  expect(layer).toMatch(/isovalue:140,[\d.]+;colour:c8553d,/);
  expect(await parameters(page, "isovalue")).toEqual(["100"]);
  await names(page).nth(0).click();
  await expect(field).toHaveValue("100");
});

test("eye, colour, opacity and name are in the link, which opens the same again", async ({
  page,
}) => {
  await open(page, `${two}&layer=volume:mandelbulb;group:Sets;visible:off`);
  await expect(names(page)).toHaveText(["bucky", "Waves", "mandelbulb"]);
  await page.getByRole("button", { name: "Show Waves" }).click();
  await page.getByRole("slider", { name: "Opacity of bucky" }).fill("0.5");
  await row(page, "bucky").locator("input[type=color]").fill("#4f86c6");
  await names(page).nth(1).dblclick();
  await page.getByRole("textbox", { name: "Name of Waves" }).fill("Wellen; 50%: größer");
  await page.keyboard.press("Enter");
  await expect(names(page)).toHaveText(["bucky", "Wellen; 50%: größer", "mandelbulb"]);
  const layers = await parameters(page);
  expect(layers[0]).toContain("name:Wellen%3B 50%25: größer;visible:off");
  expect(layers[1]).toBe("volume:mandelbulb;group:Sets;visible:off");
  expect(await parameters(page, "opacity")).toEqual(["0.5"]);
  const url = page.url();
  await page.goto("about:blank");
  await page.goto(url);
  await complete(page);
  await expect(names(page)).toHaveText(["bucky", "Wellen; 50%: größer", "mandelbulb"]);
  await expect(page.getByRole("button", { name: "Show Wellen" })).toHaveAttribute(
    "aria-pressed",
    "false",
  );
  await settled(page);
  expect(page.url()).toBe(url);
});

test("layers are reordered by keys and by dragging, and undo restores the order", async ({
  page,
}) => {
  await open(page, `${two}&layer=volume:mandelbulb;name:Bulb;visible:off`);
  await names(page).nth(2).focus();
  await page.keyboard.press("Alt+ArrowUp");
  await expect(names(page)).toHaveText(["bucky", "Bulb", "Waves"]);
  await expect(names(page).nth(1)).toBeFocused();
  await expect(page.locator(".layers [role=status]")).toHaveText("Bulb: 2 of 3");
  await page.keyboard.press("Alt+ArrowUp");
  await expect(names(page)).toHaveText(["Bulb", "bucky", "Waves"]);
  expect(await parameters(page, "layer-order")).toEqual(["1,0,2"]);
  const grip = await row(page, "Waves").locator(".layer-grip").boundingBox();
  const first = await row(page, "Bulb").boundingBox();
  if (!grip || !first) throw new Error("no rows");
  await page.mouse.move(grip.x + 5, grip.y + grip.height / 2);
  await page.mouse.down();
  await page.mouse.move(grip.x + 5, first.y + 5, { steps: 5 });
  await expect(page.locator(".layer-line")).toBeVisible();
  await page.mouse.up();
  await expect(names(page)).toHaveText(["Waves", "Bulb", "bucky"]);
  await settled(page);
  const url = page.url();
  await page.reload();
  await complete(page);
  await expect(names(page)).toHaveText(["Waves", "Bulb", "bucky"]);
  await settled(page);
  expect(page.url()).toBe(url);
  await names(page).nth(0).press("Alt+ArrowDown");
  await expect(names(page)).toHaveText(["Bulb", "Waves", "bucky"]);
  await settled(page);
  await page.keyboard.press("Control+z");
  await expect(names(page)).toHaveText(["Waves", "Bulb", "bucky"]);
  await page.keyboard.press("Control+Shift+z");
  await expect(names(page)).toHaveText(["Bulb", "Waves", "bucky"]);
});

test("a removed layer returns with undo; the page's own volume stays", async ({ page }) => {
  await open(page, two);
  const url = page.url();
  await names(page).nth(1).click();
  await page.keyboard.press("Delete");
  await expect(names(page)).toHaveText(["bucky"]);
  await settled(page);
  expect(await parameters(page)).toEqual([]);
  await page.keyboard.press("Control+z");
  await expect(names(page)).toHaveText(["bucky", "Waves"]);
  await complete(page);
  await settled(page);
  expect(page.url()).toBe(url);
  await page.keyboard.press("Control+Shift+z");
  await expect(names(page)).toHaveText(["bucky"]);
  await names(page).nth(0).press("Delete");
  await expect(names(page)).toHaveText(["bucky"]);
  await expect(page.getByRole("button", { name: "Remove", exact: true }).first()).toBeDisabled();
});

test("all, none, solo and groups show and hide", async ({ page }) => {
  await open(
    page,
    `${two}&layer=volume:marschner_lobb;group:Sets;isovalue:60&layer=volume:mandelbulb;group:Sets`,
  );
  const eyes = page.locator(".layer-row:not(.layer-group) .layer-eye");
  const shown = () => eyes.evaluateAll((all) => all.map((eye) => eye.getAttribute("aria-pressed")));
  await names(page).nth(1).click();
  await page.getByRole("button", { name: "Show only this" }).click();
  await expect.poll(shown).toEqual(["false", "true", "false", "false"]);
  await page.getByRole("button", { name: "Show only this" }).click();
  await expect.poll(shown).toEqual(["true", "true", "true", "true"]);
  await page.getByRole("button", { name: "Show the group Sets" }).click();
  await expect.poll(shown).toEqual(["true", "true", "false", "false"]);
  await page.getByRole("button", { name: "Hide all" }).click();
  await expect.poll(shown).toEqual(["false", "false", "false", "false"]);
  await expect(page.locator(".status-state")).toContainText("no surface in this view");
  await page.getByRole("button", { name: "Show all" }).click();
  await expect.poll(shown).toEqual(["true", "true", "true", "true"]);
  await page.getByRole("button", { name: "Sets, 2 layers" }).click();
  await expect(names(page)).toHaveText(["bucky", "Waves"]);
  await page.getByRole("button", { name: "Sets, 2 layers" }).click();
  await expect(names(page)).toHaveCount(4);
});

test("measurements state the layer that they hit; differing frames of reference are noted", async ({
  page,
}) => {
  await open(page, `volume=bucky&isovalue=100&${look}&layer=volume:mandelbulb;name:Bulb`);
  await expect(page.locator(".layers-note")).toHaveText(
    /^bucky, Bulb: their files do not say where they lie\./,
  );
  await page.getByRole("button", { name: "Show bucky" }).click();
  await names(page).nth(1).click();
  await openSection(page, "Measure");
  await page.getByRole("button", { name: "Point", exact: true }).click();
  await page.keyboard.press("v"); // the whole volume is in the picture
  await settled(page);
  await page.keyboard.press("Enter");
  await expect(page.locator(".measurement-facts").first()).toContainText("on Bulb · voxel");
  const [download] = await Promise.all([
    page.waitForEvent("download"),
    page.getByRole("button", { name: "CSV" }).click(),
  ]);
  const [head, line] = readFileSync(await download.path(), "utf8").split("\r\n");
  expect(head).toMatch(/,angle_degrees,layer$/);
  expect(line).toMatch(/,Bulb$/);
});

test("a layer that cannot be opened is named, and the others stay", async ({ page }) => {
  await page.goto(
    `${server.url}?${two}&layer=volume:no_such_volume;name:Lost&layer=index:7;visible:off&layer=nonsense`,
  );
  await expect(page.locator(".toast")).toContainText("Lost could not be opened");
  await complete(page);
  await expect(names(page)).toHaveText(["bucky", "Waves"]);
});

test("a thousand layers of a session: few rows in the document, search, and nothing fetched", async ({
  page,
}) => {
  const layers = Array.from({ length: 1000 }, (_, i) => {
    const group = i >= 500 ? `;group:Organs ${Math.floor(i / 100)}` : "";
    return `&layer=volume:mandelbulb;name:Label ${i + 1}${group};visible:off`;
  });
  const session = {
    format: "isosplat-session",
    version: 1,
    view: `?volume=bucky&isovalue=100&${look}${layers.join("")}`,
    measurements: [],
  };
  const urls: string[] = [];
  page.on("request", (request) => urls.push(request.url()));
  await page.goto(server.url);
  await page.getByLabel("choose files").setInputFiles({
    name: "session.isosplat.json",
    mimeType: "application/json",
    buffer: Buffer.from(JSON.stringify(session)),
  });
  await expect(page).toHaveURL(/volume=bucky/);
  urls.length = 0; // the start page shows pictures of all volumes
  await complete(page);
  const rows = page.locator(".layer-row");
  await expect(names(page).first()).toHaveText("bucky");
  const elements = () => page.evaluate(() => document.querySelectorAll("*").length);
  const drawn = async () => {
    expect(await rows.count()).toBeLessThan(25);
    expect(await page.locator(".layer-list *").count()).toBeLessThan(500);
  };
  await drawn();
  const before = await elements();
  await names(page).first().focus();
  await page.keyboard.press("End");
  await expect(names(page).last()).toHaveText("Label 1000");
  await expect(names(page).last()).toBeFocused();
  await drawn();
  expect(Math.abs((await elements()) - before)).toBeLessThan(300);
  // 1001 layers, and a row for each of the five groups.
  await expect(rows.last()).toHaveAttribute("aria-setsize", "1006");
  await expect(rows.last()).toHaveAttribute("aria-posinset", "1006");
  await page.getByRole("searchbox", { name: "Search the layers" }).fill("label 1000");
  await expect(names(page)).toHaveText(["Label 1000"]);
  await page.getByRole("searchbox").fill("Organs 7");
  await expect(names(page).first()).toHaveText("Label 507");
  await drawn();
  await settled(page);
  expect(urls.filter((url) => url.includes("mandelbulb/"))).toEqual([]);
  // The address has no room for the layers, so this tab keeps them.
  expect(await parameters(page)).toEqual([]);
  await expect(page.locator(".toast")).toContainText("layers do not fit into the address");
  await page.reload();
  await complete(page);
  await expect(rows.last()).toHaveAttribute("aria-setsize", "1006");
});

test("a link with layers in German", async ({ page }) => {
  await page.goto(`${server.url}?lang=de&${two}`);
  await expect(page.getByRole("button", { name: "Ebenen", exact: true })).toBeVisible();
  await expect(page.getByRole("button", { name: "Nur diese zeigen" })).toBeVisible();
  await expect(page.getByRole("slider", { name: "Deckkraft von Waves" })).toBeVisible();
  expect(await findings(page)).toEqual([]);
});

test.describe("on a phone", () => {
  test.use({ viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true });

  test("the list is in the sheet, and the chosen layer is named above it", async ({ page }) => {
    await open(page, two);
    await expect(page.locator(".isovalue-layer")).toHaveText("bucky");
    await expect(page.locator(".layer-list")).toBeHidden();
    await page.getByRole("button", { name: "More controls" }).tap();
    await expect(page.locator(".layer-list")).toBeVisible();
    await names(page).nth(1).tap();
    await expect(page.locator(".isovalue-layer")).toHaveText("Waves");
    const panel = page.locator(".panel");
    const isCut = await panel.evaluate((element) => element.scrollWidth > element.clientWidth);
    expect(isCut).toBe(false);
    expect(await findings(page)).toEqual([]);
  });
});
