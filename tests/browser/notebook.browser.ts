// The widget for notebooks, without a notebook. A page of another origin uses the module of a real
// server, with a model that follows anywidget's front-end specification (AFM).
import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { expect, type Page, test } from "@playwright/test";
import type { NotebookModel } from "../../web/element/notebook.ts";
import type { Traits } from "../../web/element/notebook_traits.ts";
import { traitDefaults } from "../../web/element/notebook_traits.ts";
import { rangeHost } from "../support/range_host.ts";
import { ballIsovalue, buildBall } from "../support/series.ts";
import { type HtmlHost, htmlHost } from "./support/html_host.ts";
import { demoFolder, program, type RunningServer, serve } from "./support/server.ts";

interface Notebook {
  /** Sets traits like the kernel: first all of them, then the events. */
  receive(values: Partial<Record<keyof Traits, unknown>>): void;
  traits: Traits;
  /** The traits that each save_changes() sent to the kernel. */
  sent: Partial<Traits>[];
  listeners(): number;
  /** Shows the model in another view. Returns a function that removes this view. */
  show(): Promise<() => void>;
  contexts: WebGL2RenderingContext[];
}
declare global {
  var notebook: Notebook;
}

let server: RunningServer;
let pages: HtmlHost;

test.beforeAll(async () => {
  server = await serve([demoFolder], 0, ["--cors", "*"]);
  pages = await htmlHost(() => "<!doctype html><title>notebook</title>");
});
test.afterAll(async () => {
  pages?.stop();
  await server?.stop();
});

/** Opens a page with a model that has these traits. No view shows it yet. */
async function open(page: Page, traits: Partial<Traits>): Promise<void> {
  await page.goto(pages.origin);
  const module = `${server.url}isosplat-anywidget.js`;
  const src = `${server.url}v1/volumes/bucky`;
  await page.evaluate(
    async ({ module, traits }) => {
      const { default: widget } = await import(module);
      const listeners = new Map<string, Set<() => void>>();
      const unsaved = new Set<string>();
      const values: Record<string, unknown> = structuredClone(traits);
      const emit = (name: string) => {
        for (const listener of [...(listeners.get(`change:${name}`) ?? [])]) listener();
      };
      const sent: Partial<Traits>[] = [];
      const model: NotebookModel = {
        get: (name) => values[name],
        set(name, value) {
          // Traits reach the kernel as JSON, so only values that JSON can represent may be set.
          if (JSON.stringify(value) === JSON.stringify(values[name])) return;
          values[name] = JSON.parse(JSON.stringify(value));
          unsaved.add(name);
          emit(name);
        },
        save_changes() {
          sent.push(Object.fromEntries([...unsaved].map((name) => [name, values[name]])));
          unsaved.clear();
        },
        on(event, listener) {
          listeners.set(event, (listeners.get(event) ?? new Set()).add(listener));
        },
        off: (event, listener) => void listeners.get(event)?.delete(listener),
      };
      const contexts: WebGL2RenderingContext[] = [];
      const { getContext } = HTMLCanvasElement.prototype;
      HTMLCanvasElement.prototype.getContext = function (this: HTMLCanvasElement, ...args: never) {
        const context = getContext.apply(this, args);
        if (context instanceof WebGL2RenderingContext && !contexts.includes(context)) {
          contexts.push(context);
        }
        return context;
      } as typeof getContext;
      globalThis.notebook = {
        receive(changes) {
          Object.assign(values, changes);
          for (const name of Object.keys(changes)) emit(name);
        },
        traits: values as unknown as Traits,
        sent,
        listeners: () => [...listeners.values()].reduce((sum, { size }) => sum + size, 0),
        async show() {
          const el = document.body.appendChild(document.createElement("div"));
          el.style.width = "400px";
          return widget.render({ model, el });
        },
        contexts,
      };
    },
    { module, traits: { ...traitDefaults, src, ...traits } },
  );
}

const trait = (page: Page, name: keyof Traits) =>
  page.evaluate((name) => globalThis.notebook.traits[name], name);
const complete = (page: Page) => expect.poll(() => trait(page, "complete")).toBe(true);
const isovalues = (page: Page) =>
  page.evaluate(() => [...document.querySelectorAll("isosplat-viewer")].map((e) => e.isovalues));

test("a program's changes reach the picture, and a visitor's the program", async ({ page }) => {
  await open(page, { isovalue: 100, height: "250px", background: "102030" });
  await page.evaluate(() => globalThis.notebook.show());
  await complete(page);
  const view = page.locator("isosplat-viewer");
  expect(await isovalues(page)).toEqual([[100]]);
  expect((await view.boundingBox())?.height).toBe(250);
  expect(await trait(page, "state")).toBe("complete");
  expect(await trait(page, "fault")).toBe("");
  expect((await trait(page, "volume")) as Traits["volume"]).toMatchObject({
    voxels: [expect.any(Number), expect.any(Number), expect.any(Number)],
  });
  // The values that the picture has determined are sent.
  await expect
    .poll(() => page.evaluate(() => Object.assign({}, ...globalThis.notebook.sent).camera?.azimuth))
    .toBe(30);

  // Changes that the kernel made are not sent back to it.
  await page.evaluate(() => {
    globalThis.notebook.sent.length = 0;
    globalThis.notebook.receive({
      surfaces: [
        { isovalue: 90, colour: "#c8553d", opacity: 0.5 },
        { isovalue: 140, colour: "#3d55c8", opacity: 1 },
      ],
      clip: { low: [0, 0, 0], high: [1, 1, 0.75], planes: [] },
      slices: { along: [0.5, null, null] },
      camera: { azimuth: 75 },
    });
  });
  await expect.poll(() => isovalues(page)).toEqual([[90, 140]]);
  expect(await trait(page, "isovalue")).toBe(90);
  const set = await view.evaluate((e: HTMLElementTagNameMap["isosplat-viewer"]) => ({
    azimuth: e.camera?.azimuth,
    high: e.clip.high,
    along: e.slices.along,
  }));
  expect(set).toEqual({ azimuth: 75, high: [1, 1, 0.75], along: [0.5, null, null] });
  // A partial camera is completed, and the isovalue follows the surfaces. No other traits are sent.
  await expect
    .poll(() => page.evaluate(() => Object.keys(Object.assign({}, ...globalThis.notebook.sent))))
    .toEqual(expect.arrayContaining(["isovalue", "camera"]));
  const sent = await page.evaluate(() => Object.assign({}, ...globalThis.notebook.sent));
  expect(sent).not.toHaveProperty("surfaces");
  expect(sent).not.toHaveProperty("clip");
  expect(sent).not.toHaveProperty("slices");
  expect(sent.camera).toMatchObject({ azimuth: 75, elevation: expect.any(Number) });

  // A visitor's change reaches the program.
  await view.getByLabel("Isovalue as a number").fill("120,5");
  await page.keyboard.press("Enter");
  await view.getByRole("application").press("ArrowLeft");
  expect(await trait(page, "isovalue")).toBe(120.5);
  expect(await trait(page, "surfaces")).toMatchObject([{ isovalue: 120.5 }, { isovalue: 140 }]);
  const saved = () => page.evaluate(() => Object.assign({}, ...globalThis.notebook.sent));
  await expect.poll(saved).toMatchObject({ isovalue: 120.5, camera: { azimuth: 80 } });

  // A click picks the surface in the middle.
  await page.evaluate(() => globalThis.notebook.receive({ clip: null, camera: { azimuth: 30 } }));
  await complete(page);
  await expect
    .poll(async () => {
      await view.click({ position: { x: 200, y: 120 } });
      return trait(page, "picked");
    })
    .toMatchObject({
      isovalue: expect.any(Number),
      position: [expect.any(Number), expect.any(Number), expect.any(Number)],
    });
});

test("a value that cannot be applied is a fault, until it is corrected or a visitor changes it", async ({
  page,
}) => {
  await open(page, { isovalue: 100 });
  await page.evaluate(() => globalThis.notebook.show());
  await complete(page);
  await page.evaluate(() => globalThis.notebook.receive({ isovalue: "sixty" }));
  await expect
    .poll(() => trait(page, "fault"))
    .toBe('isovalue: expected a finite number, found "sixty"');
  expect(await isovalues(page)).toEqual([[100]]);
  expect(await trait(page, "isovalue")).toBe("sixty");
  await page.evaluate(() => globalThis.notebook.receive({ isovalue: 110 }));
  await expect.poll(() => trait(page, "fault")).toBe("");
  expect(await isovalues(page)).toEqual([[110]]);

  await page.evaluate(() => globalThis.notebook.receive({ isovalue: "sixty" }));
  await expect.poll(() => trait(page, "fault")).toContain("sixty");
  await page.locator("isosplat-viewer").getByRole("application").press("ArrowLeft");
  expect(await trait(page, "fault")).toBe("");
  expect(await trait(page, "isovalue")).toBe(110);

  const absent = `${server.url}v1/volumes/absent`;
  await page.evaluate((src) => globalThis.notebook.receive({ src }), absent);
  await expect.poll(() => trait(page, "fault")).toContain("absent");
  expect(await trait(page, "volume")).toBeNull();
  expect(await trait(page, "complete")).toBe(false);
  // Another volume and its isovalue are set together, without a fault.
  const src = absent.replace("absent", "mandelbulb");
  await page.evaluate((src) => globalThis.notebook.receive({ isovalue: 80, src }), src);
  await complete(page);
  expect(await isovalues(page)).toEqual([[80]]);
  expect(await trait(page, "fault")).toBe("");
});

test("two views of a model move together, and removed views release everything", async ({
  page,
}) => {
  await open(page, { isovalue: 100 });
  const handles = await page.evaluateHandle(async () => {
    const { show } = globalThis.notebook;
    return [await show(), await show()];
  });
  await complete(page);
  const listeners = await page.evaluate(() => globalThis.notebook.listeners());
  expect(listeners).toBeGreaterThan(0);
  const views = page.locator("isosplat-viewer");
  const cameras = () =>
    page.evaluate(() =>
      [...document.querySelectorAll("isosplat-viewer")].map((e) => e.camera?.azimuth),
    );
  await expect.poll(cameras).toEqual([30, 30]);
  await views.first().getByRole("application").press("ArrowLeft");
  await expect.poll(cameras).toEqual([35, 35]);
  await views.last().getByRole("application").press("ArrowLeft");
  await views.last().getByRole("application").press("ArrowLeft");
  await expect.poll(cameras).toEqual([45, 45]);
  await views.last().getByLabel("Isovalue as a number").fill("120");
  await page.keyboard.press("Enter");
  await expect.poll(() => isovalues(page)).toEqual([[120], [120]]);

  // Many changes are sent in few messages, and a view that is removed sends its pending changes.
  const counts = await handles.evaluate(([first]) => {
    const { sent, receive } = globalThis.notebook;
    receive({});
    sent.length = 0;
    const [view] = document.querySelectorAll("isosplat-viewer");
    if (!view) throw new Error("no view");
    for (let i = 0; i < 50; ++i) view.isovalues = [100 + i];
    const before = sent.length;
    first?.();
    return { before, after: sent.map(({ isovalue }) => isovalue) };
  });
  expect(counts).toEqual({ before: 0, after: [149] });
  await expect.poll(() => isovalues(page)).toEqual([[149]]);
  expect(await page.evaluate(() => globalThis.notebook.listeners())).toBe(listeners / 2);

  const left = await handles.evaluate(([, second]) => {
    second?.();
    second?.(); // a second call does nothing
    const { contexts, listeners } = globalThis.notebook;
    return {
      elements: document.querySelectorAll("isosplat-viewer, canvas").length,
      made: contexts.length,
      live: contexts.filter((context) => !context.isContextLost()).length,
      listeners: listeners(),
    };
  });
  expect(left).toEqual({ elements: 0, made: 2, live: 0, listeners: 0 });
});

test("scene, step and layers: the program's and the visitor's", async ({ page }) => {
  const folder = mkdtempSync(join(tmpdir(), "isosplat-notebook-"));
  for (const step of [0, 1, 2]) {
    buildBall(folder, `${step}`, 40, { centre: [0.3 + 0.2 * step, 0.5, 0.5], radius: 0.2 });
  }
  const scene = {
    format: "isosplat-scene",
    version: 1,
    time: { steps: [0, 10, 20], unit: "s" },
    layers: [
      {
        stores: ["0.isosplat", "1.isosplat", "2.isosplat"],
        surfaces: [{ isovalue: ballIsovalue }],
      },
    ],
  };
  writeFileSync(join(folder, "scene.json"), JSON.stringify(scene));
  const bundle = join(folder, "run.isobundle");
  execFileSync(program, ["bundle", join(folder, "scene.json"), "-o", bundle]);
  const host = await rangeHost((path) => readFileSync(join(folder, path)));
  try {
    await open(page, { src: "", scene: `${host.origin}/run.isobundle`, step: 1 });
    await page.evaluate(() => globalThis.notebook.show());
    await complete(page);
    expect(await trait(page, "time")).toEqual({ values: [0, 10, 20], unit: "s" });
    const view = page.locator("isosplat-viewer");
    const state = () =>
      view.evaluate((e: HTMLElementTagNameMap["isosplat-viewer"]) => ({
        step: e.time?.step,
        layers: e.viewer?.layers.map(({ name, visible }) => `${name} ${visible}`),
        children: [...e.querySelectorAll("isosplat-layer")].map(({ layer }) => layer?.id),
      }));
    expect(await state()).toMatchObject({ step: 1, layers: [" true"] });
    await page.evaluate(() => globalThis.notebook.receive({ step: 2 }));
    await expect.poll(state).toMatchObject({ step: 2 });
    await view.getByRole("slider", { name: "Time" }).press("ArrowLeft");
    await expect.poll(() => trait(page, "step")).toBe(1);

    const src = `${server.url}v1/volumes/bucky`;
    const layers = [
      { src, name: "one" },
      { src: src.replace("bucky", "mandelbulb"), name: "two" },
    ];
    await page.evaluate((layers) => globalThis.notebook.receive({ layers }), layers);
    await expect.poll(state).toMatchObject({ layers: [" true", "one true", "two true"] });
    const [, two] = (await state()).children;
    // The remaining layer is not opened again.
    const left = [{ ...layers[1], visible: false }];
    await page.evaluate((layers) => globalThis.notebook.receive({ layers }), left);
    await expect.poll(state).toEqual({ step: 1, layers: [" true", "two false"], children: [two] });
    await page.evaluate(() => globalThis.notebook.receive({ layers: [{ name: "none" }] }));
    await expect.poll(() => trait(page, "fault")).toMatch(/^layers: expected a list/);
  } finally {
    host.stop();
    rmSync(folder, { recursive: true, force: true });
  }
});
