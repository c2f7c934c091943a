// <isosplat-viewer> in pages with one script element: attributes, events, linked and many views.
import { expect, type Page, test } from "@playwright/test";
import type { IsosplatViewerElement } from "../../web/element/index.ts";
import { type HtmlHost, htmlHost } from "./support/html_host.ts";
import { demoFolder, type RunningServer, serve } from "./support/server.ts";

let server: RunningServer;
let pages: HtmlHost;
let body = "";

test.beforeAll(async () => {
  server = await serve([demoFolder], 0, ["--cors", "*"]);
  pages = await htmlHost(
    () =>
      `<!doctype html><script type="module" src="${server.url}isosplat-viewer.js"></script>${body}`,
  );
});
test.afterAll(async () => {
  pages?.stop();
  await server?.stop();
});

const element = (volume: string, attributes: string, style = "width: 300px"): string =>
  `<isosplat-viewer src="${server.url}v1/volumes/${volume}" style="${style}" ${attributes}></isosplat-viewer>`;

async function open(page: Page, html: string): Promise<void> {
  body = html;
  await page.goto(pages.origin);
  await page.evaluate(() => customElements.whenDefined("isosplat-viewer"));
}

/** Waits until this many elements have reported a complete picture: their pictures are drawn in turn. */
const completed = (page: Page, count: number) =>
  expect
    .poll(
      () =>
        page.evaluate(
          () =>
            [...document.querySelectorAll("isosplat-viewer")].filter((e) => e.progress?.complete)
              .length,
        ),
      { timeout: 10_000 * (1 + count) },
    )
    .toBe(count);

/** The number of elements that have a WebGL context, and of those that show a still picture. */
const pictures = (page: Page) =>
  page.evaluate(() => {
    const count = (selector: string) =>
      [...document.querySelectorAll("isosplat-viewer")].filter((e) =>
        e.shadowRoot?.querySelector(selector),
      ).length;
    return { live: count("canvas"), still: count(".picture > img") };
  });

test("a surface is saved as triangles, in a worker of another origin", async ({ page }) => {
  await open(page, element("bucky", 'isovalue="100"'));
  await completed(page, 1);
  const saved = await page.locator("isosplat-viewer").evaluate(async (e: IsosplatViewerElement) => {
    const shares: number[] = [];
    const options = { format: "ply", progress: (share: number) => shares.push(share) } as const;
    const { file, triangles, vertices } = await e.saveSurface(options);
    return { triangles, vertices, bytes: file.size, begin: await file.slice(0, 4).text(), shares };
  });
  expect(saved.begin).toBe("ply\n");
  expect(saved.triangles).toBeGreaterThan(100_000);
  // A header; vertices of 24 bytes, triangles of 13.
  const header = saved.bytes - 24 * saved.vertices - 13 * saved.triangles;
  expect(header).toBeGreaterThan(200);
  expect(header).toBeLessThan(400);
  expect(saved.shares.at(-1)).toBe(1);
});

test("the projection follows the camera and the attribute", async ({ page }) => {
  await open(page, element("bucky", 'isovalue="100" projection="orthographic"'));
  await completed(page, 1);
  const view = page.locator("isosplat-viewer");
  const found = await view.evaluate((e: IsosplatViewerElement) => {
    const seen: (string | undefined)[] = [];
    const see = () =>
      seen.push(
        e.projection,
        e.camera?.projection ?? "perspective",
        e.getAttribute("projection") ?? "",
      );
    const { projection: _, ...camera } = e.camera ?? {};
    e.camera = { ...camera } as NonNullable<typeof e.camera>;
    see();
    e.camera = { ...camera, projection: "perspective" } as NonNullable<typeof e.camera>;
    see();
    e.projection = "orthographic";
    see();
    return seen;
  });
  const three = (name: string) => [name, name, name];
  expect(found).toEqual(["orthographic", "perspective", "orthographic"].flatMap(three));
});

test("a view of another origin: attributes, controls, events and faults", async ({ page }) => {
  await open(page, element("bucky", 'isovalue="100" colour="c8553d" controls'));
  await completed(page, 1);
  const view = page.locator("isosplat-viewer");
  const slider = view.getByLabel("Isovalue", { exact: true });
  await expect(slider).toHaveValue("100");
  expect(await view.evaluate((e: IsosplatViewerElement) => e.surfaces)).toEqual([
    { isovalue: 100, colour: "#c8553d", opacity: 1 },
  ]);

  const events = await view.evaluateHandle((e: IsosplatViewerElement) => {
    const seen: string[] = [];
    e.addEventListener("isovaluechange", ({ detail }) => seen.push(`isovalue ${detail}`));
    e.addEventListener("camerachange", ({ detail }) => seen.push(`camera ${detail.azimuth}`));
    e.addEventListener("fault", ({ detail }) => seen.push(`fault ${detail.kind}`));
    return seen;
  });
  await view.getByLabel("Isovalue as a number").fill("120,5");
  await page.keyboard.press("Enter");
  await expect(slider).toHaveValue("120.5");
  await view.getByRole("application").press("ArrowLeft");
  await view.evaluate((e: IsosplatViewerElement) => {
    e.removeAttribute("isovalue");
    e.src = e.src.replace("bucky", "absent");
  });
  await expect(view.getByRole("status")).toHaveText(
    /^No such volume: http.*the server answers 404/,
  );
  expect(await events.jsonValue()).toEqual(["isovalue 120.5", "camera 35", "fault not-found"]);
});

test("axes, a scale bar and the clip box above the picture; attributes that frameworks unset", async ({
  page,
}) => {
  await open(page, element("bucky", 'isovalue="100" show="axes, scale,clip" controls'));
  await completed(page, 1);
  const view = page.locator("isosplat-viewer");
  await expect(view.getByRole("img", { name: /^Scale: the bar is/ })).toBeVisible();
  const state = () =>
    view.evaluate((e: IsosplatViewerElement) => ({
      azimuth: Math.round(e.camera?.azimuth ?? 0),
      elevation: Math.round(e.camera?.elevation ?? 0),
      high: e.clip.high,
      isovalues: e.isovalues,
    }));
  // Look from above, by pointer. Then go to the next end of the axes, by keys.
  await view.getByRole("button", { name: "View from z", exact: true }).click();
  await expect.poll(async () => (await state()).elevation).toBe(90);
  await view.getByRole("button", { name: "View from −x", exact: true }).focus();
  await page.keyboard.press("Enter");
  await expect.poll(async () => (await state()).elevation).toBe(0);
  await view.getByRole("slider", { name: "Upper y face of the clip box" }).press("PageDown");
  expect((await state()).high).toEqual([1, 0.9, 1]);
  await completed(page, 1);
  const sliced = await view.evaluate((e: IsosplatViewerElement) => {
    e.slices = { along: [0.5, null, null] };
    return { along: e.viewer?.slices.along, range: e.viewer?.legend?.range, set: e.slices.along };
  });
  expect(sliced).toEqual({ along: [0.5, null, null], range: [0.5, 231.5], set: [0.5, null, null] });
  await view.evaluate((e: IsosplatViewerElement) => {
    e.isovalues = [120];
    e.isovalues = undefined;
    e.clip = undefined;
    e.slices = undefined;
    e.setAttribute("show", "box");
  });
  expect(await view.evaluate((e: IsosplatViewerElement) => e.viewer?.legend)).toBeNull();
  expect(await state()).toMatchObject({ high: [1, 1, 1], isovalues: [100] });
  await expect(view.getByRole("slider", { name: "Upper y face of the clip box" })).toHaveCount(0);
  await expect(view.getByRole("button", { name: "View from z", exact: true })).toHaveCount(0);
  await view.evaluate((e: IsosplatViewerElement) => e.setAttribute("show", "axes,compass"));
  await expect(view.getByRole("status")).toContainText("some of axes,scale,box,clip");
});

test("another volume begins with its own isovalue, and changed colours keep it", async ({
  page,
}) => {
  await open(page, element("bucky", ""));
  await completed(page, 1);
  const isovalues = await page.locator("isosplat-viewer").evaluate(async (e) => {
    const view = e as IsosplatViewerElement;
    const opened = new Promise((resolve) => view.addEventListener("opened", resolve));
    const before = view.isovalues;
    view.src = view.src.replace("bucky", "marschner_lobb");
    await opened;
    const suggested = view.info?.metadata.suggested_isovalues?.slice(0, 1);
    const after = view.isovalues;
    view.isovalues = [0.25];
    view.setAttribute("colour", "c8553d");
    return { before, after, suggested, coloured: view.surfaces };
  });
  expect(isovalues.after).toEqual(isovalues.suggested);
  expect(isovalues.after).not.toEqual(isovalues.before);
  expect(isovalues.coloured).toEqual([{ isovalue: 0.25, colour: "#c8553d", opacity: 1 }]);
});

test("a link shares only the parts that it names", async ({ page }) => {
  await open(
    page,
    element("bucky", 'isovalue="100" link="a:camera"') +
      element("bucky", 'isovalue="120" link="a:camera"'),
  );
  await completed(page, 2);
  await page.locator("isosplat-viewer").first().getByRole("application").press("ArrowLeft");
  const views = () =>
    page.evaluate(() =>
      [...document.querySelectorAll("isosplat-viewer")].map((e) => [
        e.isovalues[0],
        e.camera?.azimuth,
      ]),
    );
  await expect.poll(views).toEqual([
    [100, 35],
    [120, 35],
  ]);
  const isovalues = await page.evaluate(() => {
    const elements = [...document.querySelectorAll("isosplat-viewer")];
    const [first] = elements;
    if (first) first.isovalues = [90];
    const apart = elements.map((e) => e.isovalues[0]);
    for (const each of elements) each.link = "b:isovalues";
    return [apart, elements.map((e) => e.isovalues[0])];
  });
  expect(isovalues).toEqual([
    [90, 120],
    [90, 90],
  ]);
});

test("linked views move together, and those of other groups do not", async ({ page }) => {
  await open(
    page,
    element("bucky", 'link="a"') +
      element("mandelbulb", 'link="a" isovalue="100"') +
      element("bucky", 'isovalue="100" link="b"'),
  );
  await completed(page, 3);
  // The isovalue is the given one, not the default of the first volume.
  const isovalues = await page.evaluate(() =>
    [...document.querySelectorAll("isosplat-viewer")].map((e) => e.isovalues),
  );
  expect(isovalues).toEqual([[100], [100], [100]]);
  await page.locator("isosplat-viewer").first().getByRole("application").press("ArrowLeft");
  const cameras = () =>
    page.evaluate(() =>
      [...document.querySelectorAll("isosplat-viewer")].map((e) => e.camera?.azimuth),
    );
  await expect.poll(cameras).toEqual([35, 35, 30]);
  const cut = await page.evaluate(() => {
    const elements = [...document.querySelectorAll("isosplat-viewer")];
    const [first] = elements;
    if (first) first.clip = { low: [0, 0, 0], high: [1, 1, 0.5], planes: [] };
    return elements.map(({ clip }) => clip.high[2]);
  });
  expect(cut).toEqual([0.5, 0.5, 1]);
  const sliced = await page.evaluate(() => {
    const elements = [...document.querySelectorAll("isosplat-viewer")];
    const heard: number[] = [];
    elements.forEach((e, i) => void e.addEventListener("sliceschange", () => heard.push(i)));
    if (elements[1]) elements[1].slices = { along: [null, 0.25, null] };
    return { places: elements.map(({ slices }) => slices.along[1]), heard: heard.sort() };
  });
  expect(sliced).toEqual({ places: [0.25, 0.25, null], heard: [0, 1] });
  // Setting the same value again is no change. Another volume has other values, and keeps the
  // planes.
  const kept = await page.evaluate(() => {
    const [, , third] = document.querySelectorAll("isosplat-viewer");
    if (!third) return undefined;
    const along = [null, 0.5, null] as const;
    third.slices = { along, range: [10, 20] };
    let heard = 0;
    third.addEventListener("sliceschange", () => heard++);
    third.slices = { along: [...along], range: [10, 20] };
    const drawn = () => third.viewer?.slices.range;
    const before = drawn();
    third.src = third.src.replace("bucky", "mandelbulb");
    return { heard, slices: third.slices, drawn: [before, drawn() ?? "none"] };
  });
  expect(kept).toEqual({
    heard: 0,
    slices: { along: [null, 0.5, null] },
    drawn: [[10, 20], "none"],
  });
});

test("the example page shows linked views, and the effects of their attributes", async ({
  page,
}) => {
  const faults: string[] = [];
  page.on("pageerror", (error) => faults.push(error.message));
  await page.goto(`${server.url}embed.html`);
  await completed(page, 2);
  const shown = () =>
    page.evaluate(() => [...document.querySelectorAll("isosplat-viewer")].map((e) => e.isovalues));
  const source = page.locator("#source");
  await page.getByLabel("isovalue", { exact: true }).fill("100");
  await page.getByLabel("colour").fill("3d55c8");
  await page.getByLabel("link").fill("");
  await page.getByLabel("link").press("Tab");
  await expect.poll(shown).toEqual([[100], [100]]);
  await expect(source).toContainText(
    `<isosplat-viewer src="${server.url}v1/volumes/bucky" isovalue="100" colour="3d55c8" show="axes,scale" controls>`,
  );
  await page.getByLabel("isovalue", { exact: true }).fill("120");
  await page.getByLabel("isovalue", { exact: true }).press("Tab");
  await expect.poll(shown).toEqual([[120], [100]]);
  expect(faults).toEqual([]);
});

test("settings that are made while a volume opens are shown", async ({ page }) => {
  await open(page, "");
  const drawn = await page.evaluate(async (src) => {
    const e = document.createElement("isosplat-viewer");
    e.src = src;
    document.body.append(e);
    while (!e.viewer) await new Promise(requestAnimationFrame);
    const opened = new Promise((resolve) => e.addEventListener("opened", resolve));
    e.surfaces = [{ isovalue: 90, colour: "#c8553d", opacity: 1 }];
    e.camera = {
      target: [0, 0, 0],
      distance: 500,
      azimuth: 10,
      elevation: 0,
      roll: 0,
      fieldOfView: 30,
    };
    await opened;
    return { surfaces: e.viewer.surfaces, azimuth: e.viewer.camera?.azimuth };
  }, `${server.url}v1/volumes/bucky`);
  expect(drawn).toEqual({
    surfaces: [{ isovalue: 90, colour: "#c8553d", opacity: 1 }],
    azimuth: 10,
  });
});

test("four of many views have a WebGL context, the others a picture until they are used", async ({
  page,
}) => {
  test.slow();
  const six = Array.from({ length: 6 }, () => element("bucky", 'isovalue="100"', "width: 150px"));
  await open(page, six.join(""));
  await completed(page, 6);
  await expect.poll(() => pictures(page)).toEqual({ live: 4, still: 2 });
  const workers = page.workers().length;
  expect(workers).toBeLessThanOrEqual(4);

  const still = page.locator("isosplat-viewer").filter({ has: page.locator(".picture > img") });
  const used = await still.first().elementHandle();
  await used?.hover();
  await expect
    .poll(() => used?.evaluate((e) => e.shadowRoot?.querySelector("canvas") !== null))
    .toBe(true);
  await expect.poll(() => pictures(page)).toEqual({ live: 4, still: 2 });

  // The keyboard works as well: the focus moves from the picture to the canvas, and stays there.
  const reached = await still.first().elementHandle();
  await reached?.evaluate((e) => e.shadowRoot?.querySelector<HTMLElement>(".picture")?.focus());
  await expect
    .poll(() => reached?.evaluate((e) => e.shadowRoot?.activeElement?.tagName))
    .toBe("CANVAS");
  await expect.poll(() => pictures(page)).toEqual({ live: 4, still: 2 });
});
