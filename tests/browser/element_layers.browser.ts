// <isosplat-viewer> with several volumes: <isosplat-layer> children, scenes, and time.
import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { expect, type Page, test } from "@playwright/test";
import type { IsosplatLayerElement, IsosplatViewerElement } from "../../web/element/index.ts";
import { type RangeHost, rangeHost } from "../support/range_host.ts";
import { ballIsovalue, buildBall } from "../support/series.ts";
import { type HtmlHost, htmlHost } from "./support/html_host.ts";
import { program, type RunningServer, serve } from "./support/server.ts";

const steps = 4;
let folder: string;
let server: RunningServer;
let host: RangeHost;
let pages: HtmlHost;
let body = "";

test.beforeAll(async () => {
  folder = mkdtempSync(join(tmpdir(), "isosplat-element-"));
  for (const [name, x] of [
    ["left", 0.25],
    ["right", 0.75],
    ["middle", 0.5],
  ] as const) {
    buildBall(folder, name, 40, { centre: [x, 0.5, 0.5], radius: 0.15 });
  }
  for (let step = 0; step < steps; ++step) {
    const x = 0.3 + (0.4 * step) / (steps - 1);
    buildBall(folder, `step${step}`, 40, { centre: [x, 0.5, 0.5], radius: 0.2 });
  }
  const surfaces = (colour: string) => [{ isovalue: ballIsovalue, colour }];
  const head = { format: "isosplat-scene", version: 1 };
  const run = {
    ...head,
    name: "Run",
    time: { steps: [0, 10, 20, 30], unit: "s" },
    layers: [
      {
        name: "moving",
        stores: [0, 1, 2, 3].map((step) => `step${step}.isosplat`),
        surfaces: surfaces("#4f86c6"),
      },
    ],
    clip: { box: { low: [0, 0, 0], high: [1, 1, 0.75] } },
    slices: { along: [null, 0.5, null] },
    look: { kind: "exact", eye_dome: 0 },
    background: "#202020",
  };
  const fewer = {
    ...run,
    time: { steps: [0, 20], unit: "s" },
    layers: [{ name: "moving", stores: ["step0.isosplat", "step2.isosplat"] }],
    clip: null,
    slices: null,
    look: null,
  };
  const lost = {
    ...head,
    layers: [
      { name: "here", store: "left.isosplat", surfaces: surfaces("#c8553d") },
      { name: "lost", store: "lost.isosplat" },
    ],
  };
  for (const [name, scene] of Object.entries({ run, fewer, lost })) {
    writeFileSync(join(folder, `${name}.scene.json`), JSON.stringify(scene));
  }
  for (const name of ["run", "fewer"]) {
    const file = join(folder, `${name}.isobundle`);
    execFileSync(program, ["bundle", join(folder, `${name}.scene.json`), "-o", file]);
  }
  server = await serve([folder], 0, ["--cors", "*"]);
  host = await rangeHost((path) => {
    try {
      return readFileSync(join(folder, path));
    } catch {
      return undefined;
    }
  });
  pages = await htmlHost(
    () =>
      `<!doctype html><script type="module" src="${server.url}isosplat-viewer.js"></script>${body}`,
  );
});
test.afterAll(async () => {
  pages?.stop();
  host?.stop();
  await server?.stop();
  rmSync(folder, { recursive: true, force: true });
});

const store = (name: string) => `src="${server.url}v1/volumes/${name}"`;
const view = (attributes: string, children = "", size = 300): string =>
  `<isosplat-viewer style="inline-size: ${size}px; block-size: ${size}px" ${attributes}>${children}</isosplat-viewer>`;
const layer = (name: string, attributes = ""): string =>
  `<isosplat-layer ${store(name)} isovalue="${ballIsovalue}" ${attributes}></isosplat-layer>`;

async function open(page: Page, html: string): Promise<void> {
  body = html;
  await page.goto(pages.origin);
  await page.evaluate(() => customElements.whenDefined("isosplat-viewer"));
}

/** Waits until the elements show complete pictures of this many layers each. */
const completed = (page: Page, ...layers: number[]) =>
  expect
    .poll(() =>
      page.evaluate(() =>
        [...document.querySelectorAll("isosplat-viewer")].map((e) =>
          e.progress?.complete && !e.viewer?.isBusy ? e.viewer?.layers.length : -1,
        ),
      ),
    )
    .toEqual(layers);

const exact = (page: Page) =>
  page.evaluate(() => {
    for (const e of document.querySelectorAll("isosplat-viewer")) {
      e.look = { kind: "exact", shading: "exact", eyeDome: 0 };
    }
  });

/** The share of pixels of each main colour in the picture of the first element. */
async function colours(page: Page): Promise<Record<"red" | "green" | "blue", boolean>> {
  const bytes = await page.evaluate(async () => {
    const element = document.querySelector("isosplat-viewer");
    const bitmap = await createImageBitmap((await element?.screenshot()) as Blob);
    const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext("2d");
    context?.drawImage(bitmap, 0, 0);
    const { data } = context?.getImageData(0, 0, bitmap.width, bitmap.height) ?? { data: [] };
    const counts = [0, 0, 0];
    for (let i = 0; i < data.length; i += 4) {
      const [r = 0, g = 0, b = 0] = [data[i], data[i + 1], data[i + 2]];
      const most = Math.max(r, g, b);
      const next = [r, g, b].sort((x, y) => y - x)[1] ?? 0;
      if (most - next > 60)
        counts[[r, g, b].indexOf(most)] = (counts[[r, g, b].indexOf(most)] ?? 0) + 1;
    }
    return counts;
  });
  const [red = 0, green = 0, blue = 0] = bytes;
  return { red: red > 200, green: green > 200, blue: blue > 200 };
}

test("child elements are layers: added, changed, moved and removed at any time", async ({
  page,
}) => {
  await open(
    page,
    view(
      `${store("left")} isovalue="${ballIsovalue}" colour="ff0000"`,
      layer("right", 'name="Right" group="balls" colour="0000ff"'),
    ),
  );
  await completed(page, 2);
  await exact(page);
  expect(await colours(page)).toEqual({ red: true, green: false, blue: true });
  const first = page.locator("isosplat-viewer");
  await expect(page.locator("isosplat-layer")).toBeHidden();
  const layers = () =>
    first.evaluate((e: IsosplatViewerElement) =>
      e.viewer?.layers.map(({ name, group, visible, surfaces }) =>
        [name, group, visible, surfaces.map(({ colour }) => colour)].join(" "),
      ),
    );
  expect(await layers()).toEqual(["  true #ff0000", "Right balls true #0000ff"]);

  // A program adds another layer in front of it, and sets its properties before the element is in
  // the page.
  await first.evaluate((e: IsosplatViewerElement, src) => {
    const added = document.createElement("isosplat-layer");
    added.src = src;
    added.name = "Middle";
    added.surfaces = [{ isovalue: 100, colour: "#00ff00", opacity: 1 }];
    e.prepend(added);
  }, `${server.url}v1/volumes/middle`);
  await completed(page, 3);
  expect(await layers()).toEqual([
    "  true #ff0000",
    "Middle  true #00ff00",
    "Right balls true #0000ff",
  ]);
  expect(await colours(page)).toEqual({ red: true, green: true, blue: true });

  const events = await first.evaluateHandle((e: IsosplatViewerElement) => {
    const seen: string[] = [];
    for (const child of e.querySelectorAll("isosplat-layer")) {
      child.addEventListener("isovaluechange", ({ detail }) =>
        seen.push(`${child.name} isovalue ${detail}`),
      );
    }
    e.addEventListener("isovaluechange", ({ detail }) => seen.push(`isovalue ${detail}`));
    e.addEventListener("opened", () => seen.push("opened"));
    return seen;
  });
  await first.evaluate((e: IsosplatViewerElement) => {
    const [middle, right] = e.querySelectorAll("isosplat-layer");
    if (!middle || !right) throw new Error("no layers");
    middle.setAttribute("visible", "false");
    right.isovalues = [110];
    right.setAttribute("name", "Other");
    right.setAttribute("transform", "1,0,0,0,0,1,0,5,0,0,1,0,0,0,0,1");
    e.append(middle);
  });
  await completed(page, 3);
  expect(await layers()).toEqual([
    "  true #ff0000",
    "Other balls true #0000ff",
    "Middle  false #00ff00",
  ]);
  expect(await colours(page)).toEqual({ red: true, green: false, blue: true });
  const changed = await first.evaluate((e: IsosplatViewerElement) => {
    const [right, middle] = e.querySelectorAll("isosplat-layer");
    const { transform, surfaces } = e.viewer?.layers[1] ?? {};
    // A program may change the layers of the viewer, too.
    const shown = e.viewer?.layers[2];
    if (shown) shown.visible = true;
    return {
      up: transform?.[7],
      surfaces,
      isovalues: right?.isovalues,
      visible: middle?.visible,
      own: e.isovalues,
    };
  });
  expect(changed).toEqual({
    up: 5,
    surfaces: [{ isovalue: 110, colour: "#0000ff", opacity: 1 }],
    isovalues: [110],
    visible: true,
    own: [ballIsovalue],
  });
  await first.evaluate((e: IsosplatViewerElement) => {
    for (const child of e.querySelectorAll("isosplat-layer")) child.remove();
  });
  await completed(page, 1);
  expect(await colours(page)).toEqual({ red: true, green: false, blue: false });
  expect(await events.jsonValue()).toEqual(["Right isovalue 110"]);
});

test("child elements alone make a picture, and the controls change the first one", async ({
  page,
}) => {
  await open(page, view("controls", layer("left") + layer("right")));
  await completed(page, 2);
  const first = page.locator("isosplat-viewer");
  const state = () =>
    first.evaluate((e: IsosplatViewerElement) => ({
      isovalues: e.isovalues,
      children: [...e.querySelectorAll("isosplat-layer")].map(({ isovalues }) => isovalues[0]),
      colours: e.viewer?.layers.map(({ surfaces }) => surfaces[0]?.colour),
      range: e.info?.range[1],
    }));
  expect(await state()).toEqual({
    isovalues: [100],
    children: [100, 100],
    // Each layer has a different colour.
    colours: ["#d9ccb3", "#c8553d"],
    range: expect.any(Number),
  });
  await first.getByLabel("Isovalue as a number").fill("120");
  await page.keyboard.press("Enter");
  expect(await state()).toMatchObject({ isovalues: [120], children: [120, 100] });
  await first.evaluate((e: IsosplatViewerElement) => {
    const [child] = e.querySelectorAll("isosplat-layer");
    if (child) child.isovalues = [90];
  });
  await expect(first.getByLabel("Isovalue as a number")).toHaveValue("90");
  // When the first layer is removed, the next one becomes the first.
  await first.evaluate((e: IsosplatViewerElement) => e.querySelector("isosplat-layer")?.remove());
  await expect(first.getByLabel("Isovalue as a number")).toHaveValue("100");
});

test("a layer that is missing is named, and the others are shown", async ({ page }) => {
  await open(page, view(`${store("left")} isovalue="100"`, layer("absent") + layer("right")));
  await completed(page, 2);
  const first = page.locator("isosplat-viewer");
  await expect(first.getByRole("status")).toContainText("absent");
  const fault = await first.evaluate(async (e: IsosplatViewerElement) => {
    const child = e.querySelector("isosplat-layer") as IsosplatLayerElement;
    const kind = new Promise((resolve) =>
      child.addEventListener("fault", ({ detail }) => resolve(detail.kind)),
    );
    child.src = child.src.replace("absent", "lost");
    return kind;
  });
  expect(fault).toBe("not-found");
  await first.evaluate((e: IsosplatViewerElement) => {
    const child = e.querySelector("isosplat-layer");
    if (child) child.src = child.src.replace("lost", "middle");
  });
  await completed(page, 3);
  await expect(first.getByRole("status")).toBeHidden();

  // The volume of `src` is missing: the layers are shown.
  await open(page, view(store("absent"), layer("right")));
  await completed(page, 1);
  await expect(first.getByRole("status")).toContainText("absent");
});

test("layers return when an element gets its context again", async ({ page }) => {
  const others = Array.from({ length: 4 }, () => view(`${store("middle")}`, "", 100)).join("");
  await open(page, view(`${store("left")}`, layer("right", 'name="Right"')) + others);
  const first = page.locator("isosplat-viewer").first();
  const has = (index: number) =>
    page
      .locator("isosplat-viewer")
      .nth(index)
      // Wait until the element is not busy: a busy one would keep its context.
      .evaluate(({ viewer, progress }: IsosplatViewerElement) =>
        Boolean(viewer && !viewer.isBusy && progress?.complete),
      );
  await expect.poll(() => has(0)).toBe(true);
  // Using the other elements one after another takes its context.
  for (const index of [1, 2, 3, 4]) {
    await page.locator("isosplat-viewer").nth(index).hover();
    await expect.poll(() => has(index)).toBe(true);
  }
  expect(await first.evaluate((e: IsosplatViewerElement) => e.viewer)).toBeNull();
  const changed = await first.evaluate((e: IsosplatViewerElement) => {
    const child = e.querySelector("isosplat-layer");
    if (!child) throw new Error("no layer");
    child.isovalues = [105];
    return { layer: child.layer, isovalues: child.isovalues };
  });
  expect(changed).toEqual({ layer: null, isovalues: [105] });
  await first.hover();
  await expect
    .poll(() =>
      first.evaluate((e: IsosplatViewerElement) => e.viewer?.layers.at(1)?.surfaces[0]?.isovalue),
    )
    .toBe(105);
});

test("a scene: its layers, clipping, background and time, and a layer beside it", async ({
  page,
}) => {
  await open(page, view(`scene="${host.origin}/run.isobundle" step="1" controls`, layer("right")));
  await completed(page, 2);
  const first = page.locator("isosplat-viewer");
  const state = () =>
    first.evaluate((e: IsosplatViewerElement) => ({
      step: e.step,
      shown: e.time?.step,
      surfaces: e.surfaces,
      high: e.clip.high[2],
      slice: e.slices.along[1],
      kind: e.viewer?.look.kind,
      background: e.viewer?.look.background,
      names: e.viewer?.layers.map(({ name }) => name),
    }));
  expect(await state()).toEqual({
    step: 1,
    shown: 1,
    surfaces: [{ isovalue: ballIsovalue, colour: "#4f86c6", opacity: 1 }],
    high: 0.75,
    slice: 0.5,
    kind: "exact",
    background: "#202020",
    names: ["moving", ""],
  });
  const events = await first.evaluateHandle((e: IsosplatViewerElement) => {
    const seen: number[] = [];
    e.addEventListener("stepchange", ({ detail }) => seen.push(detail));
    return seen;
  });
  const slider = first.getByRole("slider", { name: "Time" });
  await expect(slider).toHaveAttribute("aria-valuetext", "10 s");
  await slider.press("ArrowRight");
  await expect.poll(async () => (await state()).shown).toBe(2);
  await expect(slider).toHaveAttribute("aria-valuetext", "20 s");
  await first.evaluate((e: IsosplatViewerElement) => {
    e.step = 99;
  });
  await expect.poll(async () => (await state()).shown).toBe(3);
  expect(await events.jsonValue()).toEqual([2, 3]);
  await first.getByRole("button", { name: "Play" }).click();
  await expect(first.getByRole("button", { name: "Pause" })).toBeVisible();
  await expect.poll(async () => (await events.jsonValue()).length).toBeGreaterThan(4);
  await first.getByRole("button", { name: "Pause" }).click();

  // Another scene begins with its own settings.
  await first.evaluate((e: IsosplatViewerElement) => {
    e.scene = e.scene.replace("run.isobundle", "fewer.scene.json");
  });
  await completed(page, 2);
  expect(await state()).toMatchObject({
    step: 1,
    shown: 1,
    high: 1,
    slice: null,
    kind: "automatic",
  });
  // A store is shown instead of the scene.
  await first.evaluate((e: IsosplatViewerElement, src) => {
    e.removeAttribute("scene");
    e.src = src;
  }, `${server.url}v1/volumes/left`);
  await completed(page, 2);
  expect(await state()).toMatchObject({ step: 1, background: "#ffffff", names: ["", ""] });
  await expect(slider).toBeHidden();
});

test("rate and loop: attributes, properties and controls, in German as well", async ({ page }) => {
  const run = `scene="${host.origin}/run.isobundle" controls`;
  await open(page, view(`${run} rate="2.5" loop="once" lang="de"`, "", 480));
  await completed(page, 1);
  const first = page.locator("isosplat-viewer");
  const state = () =>
    first.evaluate(({ rate, loop, time }: IsosplatViewerElement) => [
      rate,
      loop,
      time?.rate,
      time?.mode,
    ]);
  expect(await state()).toEqual([2.5, "once", 2.5, "once"]);
  const rates = first.getByRole("combobox", { name: "Schritte je Sekunde" });
  const loops = first.getByRole("combobox", { name: "Nach dem letzten Schritt" });
  await expect(rates.locator("option:checked")).toHaveText("2,5/s");
  await expect(loops.locator("option")).toHaveText(["Von vorn", "Hin und her", "Einmal"]);
  await rates.selectOption("10");
  await loops.selectOption("swing");
  expect(await state()).toEqual([10, "swing", 10, "swing"]);
  await expect(first).toHaveAttribute("loop", "once");
  // Another scene keeps them. Properties and attributes change them again.
  await first.evaluate((e: IsosplatViewerElement) => {
    e.scene = e.scene.replace("run.isobundle", "fewer.scene.json");
  });
  await completed(page, 1);
  expect(await state()).toEqual([10, "swing", 10, "swing"]);
  await first.evaluate((e: IsosplatViewerElement) => {
    e.rate = 20;
    e.setAttribute("loop", "loop");
  });
  expect(await state()).toEqual([20, "loop", 20, "loop"]);
  await expect(rates).toHaveValue("20");
  await expect(loops).toHaveValue("loop");
  await first.evaluate((e: IsosplatViewerElement) => e.setAttribute("rate", "fast"));
  await expect(first.getByRole("status")).toContainText('rate="fast": expected a number above 0');
  expect(
    await first.evaluate((e: IsosplatViewerElement) => {
      try {
        e.rate = 0;
      } catch (error) {
        return (error as Error).message;
      }
      return "";
    }),
  ).toContain("a rate above 0 and at most 60");

  // With `once`, playing ends at the last step.
  await first.evaluate((e: IsosplatViewerElement) => {
    e.loop = "once";
    e.rate = 60;
  });
  await first.getByRole("button", { name: "Abspielen" }).click();
  await expect.poll(() => first.evaluate((e: IsosplatViewerElement) => e.step)).toBe(1);
  await expect(first.getByRole("button", { name: "Abspielen" })).toBeVisible();
});

test("a missing layer of a scene is named; a wrong scene is a fault", async ({ page }) => {
  await open(page, view(`scene="${host.origin}/lost.scene.json"`));
  await completed(page, 1);
  const first = page.locator("isosplat-viewer");
  await expect(first.getByRole("status")).toContainText("the layer lost is missing");
  await first.evaluate((e: IsosplatViewerElement) => e.setAttribute("scene", "ftp://x/y"));
  await expect(first.getByRole("status")).toContainText("http or https address of a scene");
  await first.evaluate((e: IsosplatViewerElement) => e.setAttribute("step", "one"));
  await expect(first.getByRole("status")).toContainText("a whole number from 0");
});

test("linked elements show the same time, whatever the number of its step", async ({ page }) => {
  await open(
    page,
    view(`scene="${host.origin}/run.isobundle" link="a" step="2"`) +
      view(`scene="${server.url}v1/scenes/fewer" link="a"`) +
      view(`scene="${host.origin}/run.isobundle" step="3"`),
  );
  await completed(page, 1, 1, 1);
  const shown = () =>
    page.evaluate(() =>
      [...document.querySelectorAll("isosplat-viewer")].map((e) => e.time?.step ?? -1),
    );
  await expect.poll(shown).toEqual([2, 1, 3]);
  await page.evaluate(() => {
    const [, second] = document.querySelectorAll("isosplat-viewer");
    if (second) second.step = 0;
  });
  await expect.poll(shown).toEqual([0, 0, 3]);
  // The playing element leads. The elements that follow it do not change its step.
  await page.evaluate(() => {
    const [first] = document.querySelectorAll("isosplat-viewer");
    if (!first?.time) throw new Error("no time");
    first.time.mode = "once";
    first.time.play();
  });
  await expect.poll(shown).toEqual([3, 1, 3]);
});
