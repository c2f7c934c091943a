// "Save the scene": when the saved document is opened again, it gives the same picture.
import { execFileSync } from "node:child_process";
import { existsSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { expect, type Page, test } from "@playwright/test";
import { type RangeHost, rangeHost } from "../support/range_host.ts";
import { ballIsovalue, buildBall } from "../support/series.ts";
import { drop } from "./support/drop.ts";
import { program, type RunningServer, serve } from "./support/server.ts";
import { compare, complete, openSection, savedPicture, settled } from "./support/view.ts";

const look = "kind=exact&shading=exact&shade=0&theme=light";
let folder: string;
let server: RunningServer;
let host: RangeHost;
/** The scene that was saved last. */
let saved = "";

test.beforeAll(async () => {
  folder = mkdtempSync(join(tmpdir(), "isosplat-save-scene-"));
  for (const [name, x] of [
    ["left", 0.27],
    ["right", 0.73],
    ["more", 0.5],
  ] as const) {
    buildBall(folder, name, 48, { centre: [x, 0.5, 0.5], radius: 0.2 });
  }
  const surfaces = (colour: string) => [{ isovalue: ballIsovalue, colour, material: "matt" }];
  const scene = {
    format: "isosplat-scene",
    version: 1,
    name: "Balls",
    licence: "CC0",
    time: { steps: [0, 2.5], unit: "s", calendar: "none" },
    layers: [
      {
        name: "moving",
        stores: ["left.isosplat", "more.isosplat"],
        surfaces: surfaces("#c8553d"),
        doi: "10.1/x",
      },
      { name: "right", store: "right.isosplat", surfaces: surfaces("#4f86c6"), group: "blue" },
      { name: "lost", store: "lost.isosplat" },
    ],
  };
  const whole = { ...scene, layers: scene.layers.slice(0, 2) };
  writeFileSync(join(folder, "lost.scene.json"), JSON.stringify(scene));
  writeFileSync(join(folder, "pair.scene.json"), JSON.stringify(whole));
  const file = join(folder, "two.isobundle");
  execFileSync(program, ["bundle", join(folder, "pair.scene.json"), "-o", file]);
  server = await serve([folder], 0, ["--cors", "*"]);
  host = await rangeHost((path) => {
    if (path === "/saved.scene.json") return Buffer.from(saved);
    const at = join(folder, path);
    return existsSync(at) ? readFileSync(at) : undefined;
  });
});
test.afterAll(async () => {
  host?.stop();
  await server?.stop();
  rmSync(folder, { recursive: true, force: true });
});

async function open(page: Page, query: string): Promise<void> {
  await page.goto("about:blank");
  await page.goto(`${server.url}?${query}&${look}`);
  await complete(page);
  await settled(page);
}

/** Saves the scene; returns its document. */
async function save(page: Page): Promise<Record<string, unknown>> {
  const [download] = await Promise.all([
    page.waitForEvent("download"),
    page.getByRole("button", { name: "Save the scene" }).click(),
  ]);
  expect(download.suggestedFilename()).toMatch(/\.scene\.json$/);
  saved = readFileSync(await download.path(), "utf8");
  return JSON.parse(saved);
}

const rows = (page: Page) => page.locator(".layer-name");

for (const file of ["two.isobundle", "pair.scene.json"]) {
  test(`${file}, changed, is saved and gives the same picture`, async ({ page }) => {
    test.slow();
    const query = [
      `src=${host.origin}/${file}`,
      "time=2.5",
      "layer=index:1;isovalue:110;colour:3d9c93;transform:1,0,0,0,0,1,0,6,0,0,1,0",
      "layer=volume:right;name:added;isovalue:120;colour:e0a030;opacity:0.5",
      "layer=volume:more;name:off;visible:off",
      "clip=0,1,0,1,0,0.6",
      "clip-caps=on",
      "background=203040",
    ];
    await open(page, query.join("&"));
    await page.getByRole("application").press("ArrowLeft");
    await page.getByRole("application").press("+");
    await complete(page);
    await settled(page);
    const before = await savedPicture(page);
    const document = await save(page);
    await expect(page.locator(".toast")).toContainText("Balls.scene.json was saved");
    const store = (name: string) =>
      file === "two.isobundle"
        ? `${host.origin}/two.isobundle#${name}.isosplat`
        : `${host.origin}/${name}.isosplat`;
    expect(document).toMatchObject({
      licence: "CC0",
      time: { steps: [0, 2.5], unit: "s", calendar: "none", step: 1 },
      background: "#203040",
      clip: { box: { low: [0, 0, 0], high: [1, 1, 0.6] }, caps: true },
      layers: [
        {
          name: "moving",
          doi: "10.1/x",
          stores: [store("left"), store("more")],
          surfaces: [{ isovalue: ballIsovalue, colour: "#c8553d", material: "matt" }],
        },
        {
          name: "right",
          group: "blue",
          store: store("right"),
          surfaces: [{ isovalue: 110, colour: "#3d9c93" }],
          transform: [1, 0, 0, 0, 0, 1, 0, 6, 0, 0, 1, 0, 0, 0, 0, 1],
        },
        {
          name: "added",
          store: `${server.url}v1/volumes/right`,
          surfaces: [{ isovalue: 120, colour: "#e0a030", opacity: 0.5 }],
        },
        { name: "off", store: `${server.url}v1/volumes/more`, visible: false },
      ],
    });

    await open(page, `src=${host.origin}/saved.scene.json`);
    await expect(rows(page)).toHaveText(["moving", "right", "added", "off"]);
    await expect(page.locator(".time-value")).toHaveText("2.5 s");
    const { differing, covered } = await compare(page, before, await savedPicture(page));
    expect(covered).toBeGreaterThan(0.05);
    expect(differing).toBe(0);
    // Saving it again gives the same document.
    expect(await save(page)).toEqual(document);
  });
}

test("slices, look and measurements are saved, and shown again", async ({ page }) => {
  test.slow();
  const query = [
    `src=${host.origin}/pair.scene.json`,
    "kind=exact&shading=exact&colour-by=isovalue&map=magma&shade=0.5&theme=light",
    "light=30,20&material=0.2,0.9",
    "slices=0.5,,0.25&slice-plane=1,1,0,20&slice-range=20,220&slice-colours=map",
    "measure=distance,10,20,30,20,20,30|width&measure=note,5,5,5|here",
  ];
  await page.goto(`${server.url}?${query.join("&")}`);
  await complete(page);
  await settled(page);
  await openSection(page, "Measure");
  await expect(page.locator(".measurement")).toHaveCount(2);
  const before = await savedPicture(page);
  const document = await save(page);
  expect(document).toMatchObject({
    slices: {
      along: [0.5, null, 0.25],
      plane: { normal: [1, 1, 0], offset: 20 },
      range: [20, 220],
      mapped: true,
    },
    look: {
      kind: "exact",
      shading: "exact",
      colour_by: "isovalue",
      colour_map: "magma",
      light: { azimuth: 30, elevation: 20, highlight: 0.2, roughness: 0.9, occlusion: 1 },
      eye_dome: 0.5,
    },
    measurements: [
      { kind: "distance", text: "width" },
      { kind: "note", text: "here", points: [{ position: [5, 5, 5] }] },
    ],
  });
  const copy = `${server.url}?src=${host.origin}/saved.scene.json`;
  await page.goto("about:blank");
  await page.goto(`${copy}&theme=light`);
  await complete(page);
  await settled(page);
  const { differing, covered } = await compare(page, before, await savedPicture(page));
  expect(covered).toBeGreaterThan(0.05);
  expect(differing).toBe(0);
  // The address has only the settings that differ from the scene, so none of these.
  await expect(page).toHaveURL(/^((?!kind|slice|measure|light).)*$/);
  await openSection(page, "Measure");
  await expect(page.locator(".measurement")).toHaveCount(2);
  expect(await save(page)).toEqual(document);

  // Removed measurements stay removed when the page is loaded again.
  await page.getByRole("button", { name: "Remove all" }).click();
  await expect(page).toHaveURL(/measure=none/);
  await page.goto(`${page.url()}&slices=none&colour-by=isosurface`);
  await complete(page);
  await openSection(page, "Measure");
  await expect(page.locator(".measurement")).toHaveCount(0);
  const plain = await save(page);
  expect(plain).not.toHaveProperty("measurements");
  expect(plain).not.toHaveProperty("slices");
  expect(plain).toMatchObject({ look: { kind: "exact", colour_by: "isosurface" } });
});

test("a scene of a server is saved, and gives the same picture", async ({ page }) => {
  await open(page, "scene=two&time=2.5");
  const before = await savedPicture(page);
  const store = (name: string) => `${server.url}v1/scenes/two#${name}.isosplat`;
  expect(await save(page)).toMatchObject({
    layers: [{ stores: [store("left"), store("more")] }, { store: store("right") }],
  });
  await open(page, `src=${host.origin}/saved.scene.json`);
  const { differing } = await compare(page, before, await savedPicture(page));
  expect(differing).toBe(0);
});

test("a saved scene is opened from this device, and its layers from their addresses", async ({
  page,
}) => {
  await open(page, `src=${host.origin}/two.isobundle`);
  await save(page);
  // The name that browsers give to a second download.
  const file = { name: "Balls.scene (1).json", mimeType: "application/json" };
  await page.goto(server.url);
  await page
    .locator(".device-drop input")
    .first()
    .setInputFiles({ ...file, buffer: Buffer.from(saved) });
  await complete(page);
  await expect(rows(page)).toHaveText(["moving", "right"]);
});

test("a volume alone is saved as a scene, and a missing layer is kept", async ({ page }) => {
  await open(page, "volume=left&isovalue=120");
  await openSection(page, "Layers");
  expect(await save(page)).toMatchObject({
    layers: [{ store: `${server.url}v1/volumes/left`, surfaces: [{ isovalue: 120 }] }],
  });
  await open(page, `src=${host.origin}/lost.scene.json`);
  const { layers } = await save(page);
  expect(layers).toMatchObject([
    { name: "moving" },
    { name: "right" },
    { name: "lost", store: `${host.origin}/lost.isosplat` },
  ]);
});

test("layers of this device have no addresses: they are named, or saving is refused, in German as well", async ({
  page,
}) => {
  await page.goto(`${server.url}?lang=de`);
  const input = page.locator(".device-drop input").first();
  await input.setInputFiles(join(folder, "two.isobundle"));
  await expect(page.locator(".status-state")).toHaveText(/^vollständig/);
  await page.getByRole("button", { name: "Szene speichern" }).click();
  await expect(page.locator(".toast")).toContainText("Es wurde keine Szene gespeichert");

  await page.goto(`${server.url}?volume=left&lang=en`);
  await complete(page);
  await page.waitForFunction(() => document.querySelector("link[href*=device_files]") !== null);
  await drop(page, [resolve(folder, "right.isosplat")]);
  await page.getByRole("button", { name: "Add to the picture" }).click();
  await expect(rows(page)).toHaveCount(2);
  await complete(page);
  expect(await save(page)).toMatchObject({ layers: [{ store: `${server.url}v1/volumes/left` }] });
  await expect(page.locator(".toast")).toContainText("was saved without right");
});
