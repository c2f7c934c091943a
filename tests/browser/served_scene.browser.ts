// Scenes of a server in the page: the start list, the first picture, and scenes that change while
// they are open.
import { execFileSync } from "node:child_process";
import { mkdirSync, mkdtempSync, renameSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { expect, type Page, test } from "@playwright/test";
import { ballIsovalue, buildBall } from "../support/series.ts";
import { findings } from "./support/accessibility.ts";
import { program, type RunningServer, serve } from "./support/server.ts";
import { complete, openSection, settled } from "./support/view.ts";

const look = "kind=exact&shading=exact";
let folder: string;
let server: RunningServer;

const surfaces = (colour: string) => [{ isovalue: ballIsovalue, colour }];
const scene = {
  format: "isosplat-scene",
  version: 1,
  name: "Two balls",
  layers: [
    { name: "left", store: "left.isosplat", surfaces: surfaces("#c8553d") },
    { name: "right", store: "right.isosplat", surfaces: surfaces("#4f86c6") },
  ],
};

test.beforeAll(async () => {
  folder = mkdtempSync(join(tmpdir(), "isosplat-served-"));
  mkdirSync(join(folder, "balls"));
  for (const [name, x] of [
    ["left", 0.27],
    ["right", 0.73],
  ] as const) {
    buildBall(join(folder, "balls"), name, 72, { centre: [x, 0.5, 0.5], radius: 0.2 });
  }
  const document = join(folder, "balls/scene.json");
  writeFileSync(document, JSON.stringify(scene));
  execFileSync(program, ["bundle", document, "-o", join(folder, "two.isobundle")]);
  writeFileSync(join(folder, "broken.isobundle"), "no bundle");
  server = await serve([folder]);
});
test.afterAll(async () => {
  await server?.stop();
  rmSync(folder, { recursive: true, force: true });
});

/** The paths below /v1 that the page requests, with their ranges. */
function requests(page: Page): string[] {
  const found: string[] = [];
  page.on("request", (request) => {
    const { pathname } = new URL(request.url());
    const range = request.headers().range;
    if (pathname.startsWith("/v1/")) found.push(`${pathname} ${range ?? ""}`.trim());
  });
  return found;
}

test("the start list shows scenes before volumes, and opens one by keyboard", async ({ page }) => {
  await page.goto(server.url);
  await expect(page.locator("h1")).toHaveText("Scenes and volumes");
  const scenes = page.locator(".scene-list");
  await expect(scenes.locator(".card h2")).toHaveText(["Two balls", "broken", "Two balls"]);
  const card = scenes.locator("a.card").first();
  await expect(card).toContainText("2 layers");
  await expect(card).toContainText("KB");
  await expect(card).toContainText("balls~scene");
  await expect(scenes.locator(".card.broken")).toContainText("broken.isobundle");
  // Scenes without a picture get one that this browser draws.
  await expect(scenes.locator("a.card img")).toHaveCount(2, { timeout: 30_000 });
  await card.focus();
  await page.keyboard.press("Enter");
  await complete(page);
  expect(new URL(page.url()).searchParams.get("scene")).toBe("balls~scene");
  await expect(page).toHaveTitle("Two balls · Isosplat");
  await expect(page.locator(".layer-name")).toHaveText(["left", "right"]);
});

test("a scene of a server opens by its address, like one of another server", async ({ page }) => {
  const address = new URL("v1/scenes/balls~scene", server.url).href;
  await page.goto(`${server.url}?src=${encodeURIComponent(address)}&${look}`);
  await complete(page);
  await expect(page.locator(".layer-name")).toHaveText(["left", "right"]);
});

for (const name of ["two", "balls~scene"]) {
  test(`the first picture of ${name} takes one request`, async ({ page }) => {
    const made = requests(page);
    await page.goto(`${server.url}?scene=${name}&${look}`);
    await complete(page);
    await settled(page);
    const first = `/v1/scenes/${name}/bootstrap`;
    // The preload of the page's header and the page share one response.
    expect(made.filter((each) => each === first)).toHaveLength(1);
    expect(made[0]).toBe(first);
    for (const each of made.slice(1)) {
      expect(each).toMatch(/^\/v1\/scenes\/[a-z~]+\/[0-9a-f]{16}\/file bytes=\d+-\d+$/);
    }
    await expect(page.getByRole("alert")).toHaveCount(0);
  });
}

test("the list is searched, in German and on a phone", async ({ browser }) => {
  for (let i = 0; i < 6; ++i) {
    writeFileSync(
      join(folder, `balls/more${i}.scene.json`),
      JSON.stringify({ ...scene, name: `Nummer ${i}` }),
    );
  }
  const context = await browser.newContext({
    locale: "de",
    viewport: { width: 390, height: 844 },
  });
  const page = await context.newPage();
  const more = (i: number) => page.request.get(`${server.url}v1/scenes/balls~more${i}.scene`);
  await expect.poll(async () => (await more(5)).status()).toBe(200);
  await page.goto(server.url);
  await expect(page.locator("h1")).toHaveText("Szenen und Volumen");
  await page
    .getByRole("searchbox")
    .or(page.locator(".catalog-filter input"))
    .first()
    .fill("nummer 3");
  await expect(page.locator(".scene-list a.card")).toHaveCount(1);
  await expect(page.getByRole("status").filter({ hasText: "nummer 3" })).toHaveText(
    "1 Szene mit „nummer 3“",
  );
  await expect(page.locator(".scene-list a.card")).toContainText("2 Ebenen");
  const { scrollWidth, clientWidth } = await page.evaluate(() => ({
    scrollWidth: document.documentElement.scrollWidth,
    clientWidth: document.documentElement.clientWidth,
  }));
  expect(scrollWidth).toBeLessThanOrEqual(clientWidth);
  await context.close();
});

test("a layer of the server is added to a scene, and stays in the link", async ({ page }) => {
  await page.goto(`${server.url}?scene=two&${look}`);
  await complete(page);
  await page.getByRole("button", { name: "Add a volume" }).click();
  await page.locator(".add-layer-volume").first().click();
  await expect(page.locator(".layer-name")).toHaveCount(3);
  await settled(page);
  const { searchParams } = new URL(page.url());
  expect(searchParams.get("scene")).toBe("two");
  expect(searchParams.getAll("layer").join()).toContain("balls~left");
});

test("all layers of a scene are added to a picture, or the reason is shown", async ({ page }) => {
  const own = mkdtempSync(join(tmpdir(), "isosplat-added-"));
  buildBall(own, "alone", 32, { centre: [0.5, 0.5, 0.5], radius: 0.4 });
  const label = { value: 3, voxels: 12_000, volume: 12_000 };
  const whole = {
    ...scene,
    name: "Whole",
    layers: [{ store: "alone.isosplat", name: "a", label }],
  };
  const hidden = { store: "alone.isosplat", name: "b", group: "g", visible: false };
  const two = { ...whole, layers: [...whole.layers, hidden] };
  writeFileSync(join(own, "whole.scene.json"), JSON.stringify(two));
  const steps = {
    time: { steps: [0, 1] },
    layers: [{ stores: ["alone.isosplat", "alone.isosplat"] }],
  };
  writeFileSync(join(own, "run.scene.json"), JSON.stringify({ ...scene, name: "Run", ...steps }));
  const small = await serve([own]);
  try {
    const names = page.locator(".layer-name");
    await page.goto(`${small.url}?volume=alone&isovalue=120&${look}`);
    await complete(page);
    await openSection(page, "Layers");
    await page.getByRole("button", { name: "Add a volume" }).click();
    await page.getByRole("button", { name: /Run .*scene of 1 layer · 2 steps/ }).click();
    await expect(page.locator(".toast")).toContainText("Run changes with time");
    await page.getByRole("button", { name: "Add a volume" }).click();
    expect(await findings(page)).toEqual([]);
    await page.getByRole("button", { name: /Whole .*scene of 2 layers/ }).click();
    await expect(names).toHaveText(["alone", "a", "b"]);
    await complete(page);
    await settled(page);
    const { searchParams } = new URL(page.url());
    expect(searchParams.getAll("layer")).toEqual([
      expect.stringMatching(
        /^src:http.*v1\/scenes\/whole\.scene#alone\.isosplat;name:a;isovalue:.*;label:3,12000,12000$/,
      ),
      expect.stringMatching(/^src:http.*#alone\.isosplat;name:b;group:g;visible:off/),
    ]);
    // The link shows the same again, and one undo removes all layers that one step has added.
    await page.reload();
    await complete(page);
    await expect(names).toHaveText(["alone", "a", "b"]);
    await page.getByRole("button", { name: "Add a volume" }).click();
    await page
      .getByRole("textbox", { name: "A store or a scene at an address" })
      .fill(`${small.url}v1/scenes/whole.scene`);
    await page.getByRole("button", { name: "Add", exact: true }).click();
    // Layers of a group are listed together.
    await expect(names).toHaveText(["alone", "a", "b", "b", "a"]);
    await complete(page);
    await settled(page);
    await page.keyboard.press("Control+z");
    await expect(names).toHaveText(["alone", "a", "b"]);
  } finally {
    await small.stop();
    rmSync(own, { recursive: true, force: true });
  }
});

test("a scene that was replaced opens with its new content", async ({ page }) => {
  const file = join(folder, "changing.isobundle");
  const build = (layers: object[]) => {
    writeFileSync(join(folder, "balls/part.scene.json"), JSON.stringify({ ...scene, layers }));
    execFileSync(program, [
      "bundle",
      join(folder, "balls/part.scene.json"),
      "-o",
      `${folder}/made`,
    ]);
    renameSync(`${folder}/made`, file);
  };
  build(scene.layers);
  const status = () => page.request.get(`${server.url}v1/scenes/changing`);
  await expect.poll(async () => (await status()).status()).toBe(200);
  await page.goto(`${server.url}?scene=changing&${look}`);
  await complete(page);
  build([...scene.layers].reverse().concat(scene.layers.slice(0, 1)));
  await expect
    .poll(async () => ((await (await status()).json()) as { layers: number }).layers)
    .toBe(3);
  await page.goto("about:blank");
  await page.goto(`${server.url}?scene=changing&${look}`);
  await complete(page);
  await expect(page.locator(".layer-name")).toHaveText(["right", "left", "left"]);
});

test("a missing scene is named, and others are offered", async ({ page }) => {
  await page.goto(`${server.url}?scene=none`);
  await expect(page.getByRole("alert")).toContainText("There is no scene “none”");
  await page.getByRole("alert").getByRole("link", { name: "two" }).click();
  await complete(page);
  expect(new URL(page.url()).searchParams.get("scene")).toBe("two");
});
