// Several volumes in one viewer have one picture and one sample budget, and do not affect each
// other.
import { expect, type Page, test } from "@playwright/test";
import type * as StreamModule from "../../web/stream/index.ts";
import type * as ViewerModule from "../../web/viewer/index.ts";
import { type ServedModules, serveModules } from "./support/empty_page.ts";
import { demoFolder, type RunningServer, serve } from "./support/server.ts";

let server: RunningServer;
let modules: ServedModules;
test.beforeAll(async () => {
  server = await serve([demoFolder]);
  modules = await serveModules(server.url);
});
test.afterAll(async () => {
  await modules.close();
  await server.stop();
});

/** The variables that the tests keep in their page. */
interface Scene {
  viewer: ViewerModule.Viewer;
  source(volume: string): StreamModule.Source;
  surface(isovalue: number, colour?: string): ViewerModule.Surface[];
  events: string[];
  /** The picture at rest. */
  picture(): Promise<ImageData>;
}
declare global {
  interface Window {
    scene: Scene;
    pictures: Record<string, ImageData>;
    /** The number of pixels that differ visibly. */
    differing(a: string, b: string): number;
  }
}

async function scenePage(page: Page, options: ViewerModule.ViewerOptions = {}): Promise<void> {
  await page.goto(`${modules.origin}/empty`);
  await page.evaluate(
    async ({ base, options }) => {
      const { Viewer }: typeof ViewerModule = await import(`${base}/viewer/index.ts`);
      const { ServerSource }: typeof StreamModule = await import(`${base}/stream/index.ts`);
      const canvas = document.querySelector("canvas");
      if (!canvas) throw new Error("no canvas");
      canvas.style.cssText = "width: 300px; height: 300px";
      const viewer = new Viewer(canvas, options);
      // The automatic kind depends on frame times.
      viewer.setLook({ kind: "exact", shading: "exact" });
      const events: string[] = [];
      const names = new WeakMap<object, string>();
      const nameOf = (layer: ViewerModule.Layer) => {
        if (layer.name) names.set(layer, layer.name);
        return names.get(layer) ?? "";
      };
      viewer.on("opened", () => events.push("opened"));
      viewer.on("error", (error) => events.push(`error: ${error.message}`));
      viewer.on("layeradd", (layer) => events.push(`add ${nameOf(layer)}`));
      viewer.on("layerremove", (layer) => events.push(`remove ${nameOf(layer)}`));
      viewer.on("layermove", ({ layer, index }) => events.push(`move ${nameOf(layer)} ${index}`));
      viewer.on("layerchange", ({ property }) => events.push(`change ${property}`));
      viewer.on("layererror", ({ layer }) => events.push(`failed ${nameOf(layer)}`));
      const picture = async () => {
        // Smooth edges are always drawn: at rest, a busy machine may leave them out.
        // Changes that were made in this task are drawn in the next frame.
        await new Promise((next) => requestAnimationFrame(next));
        while (viewer.isBusy) await new Promise((next) => setTimeout(next, 20));
        const bitmap = await createImageBitmap(await viewer.screenshot());
        const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext("2d");
        if (!context) throw new Error("no context");
        context.drawImage(bitmap, 0, 0);
        return context.getImageData(0, 0, bitmap.width, bitmap.height);
      };
      window.scene = {
        viewer,
        events,
        picture,
        source: (volume) => new ServerSource({ base, volume }),
        surface: (isovalue, colour = "#d0c0b0") => [{ isovalue, colour, opacity: 1 }],
      };
      window.pictures = {};
      window.differing = (a, b) => {
        const [x, y] = [window.pictures[a], window.pictures[b]];
        if (!x || !y || x.data.length !== y.data.length) return -1;
        let count = 0;
        for (let i = 0; i < x.data.length; i += 4) {
          const isOther = [0, 1, 2].some(
            (k) => Math.abs((x.data[i + k] ?? 0) - (y.data[i + k] ?? 0)) > 24,
          );
          if (isOther) ++count;
        }
        return count;
      };
    },
    { base: modules.origin, options },
  );
}

/** Opens both volumes, and puts the small one between the eye and the centre of the large one. */
const open = (page: Page) =>
  page.evaluate(async () => {
    const { viewer, source, surface } = window.scene;
    await viewer.open(source("marschner_lobb"), { surfaces: surface(128, "#4f86c6") });
    const [first] = viewer.layers;
    if (!first?.info) throw new Error("no layer");
    first.name = "large";
    const centre = (info: StreamModule.StoreInfo) =>
      info.origin.map((o, i) => o + ((info.spacing[i] ?? 0) * ((info.voxels[i] ?? 0) - 1)) / 2);
    const added = await viewer.addLayer(source("bucky"), {
      name: "small",
      surfaces: surface(100, "#c8553d"),
    });
    if (!added.info) throw new Error("not open");
    // The small volume gets half the size of the large one, and is moved towards the eye, which
    // looks along +y.
    const size = (info: StreamModule.StoreInfo) =>
      (info.spacing[0] ?? 0) * ((info.voxels[0] ?? 0) - 1);
    const scale = (0.5 * size(first.info)) / size(added.info);
    const [x = 0, y = 0, z = 0] = centre(first.info).map(
      (to, i) => to - scale * (centre(added.info as StreamModule.StoreInfo)[i] ?? 0),
    );
    const nearer = y - size(first.info);
    added.transform = [scale, 0, 0, x, 0, scale, 0, nearer, 0, 0, scale, z, 0, 0, 0, 1];
    viewer.reset();
    const { camera } = viewer;
    if (camera) viewer.setCamera({ ...camera, azimuth: 0, elevation: 0 });
  });

test("two stores make one picture with one depth order", async ({ page }) => {
  await scenePage(page);
  await open(page);
  const seen = await page.evaluate(async () => {
    const { viewer, picture } = window.scene;
    const [large, small] = viewer.layers;
    if (!large || !small?.info || !large.info) throw new Error("no layers");
    window.pictures.both = await picture();
    const at = viewer.pick(150, 150);
    const isComplete = viewer.progress?.complete;
    const budget = [large, small].map(({ progress }) => progress?.sampleBudget ?? 0);
    const total = viewer.progress?.sampleBudget;
    // Look at the same point from behind.
    const { camera } = viewer;
    if (!camera) throw new Error("no camera");
    viewer.setCamera({ ...camera, azimuth: 180 });
    await picture();
    const behind = viewer.pick(150, 150);
    viewer.setCamera(camera);
    small.visible = false;
    window.pictures.large = await picture();
    small.visible = true;
    large.visible = false;
    window.pictures.small = await picture();
    const sizes = Object.keys(window.pictures).flatMap((a) =>
      Object.keys(window.pictures).map((b) => window.differing(a, b)),
    );
    return { at, behind, ids: [large.id, small.id], isComplete, sizes, budget, total };
  });
  expect(seen.isComplete).toBe(true);
  expect(seen.at?.layer).toBe(seen.ids[1]);
  expect(seen.at?.isovalue).toBeCloseTo(100, 0);
  expect(seen.behind?.layer).toBe(seen.ids[0]);
  // The picker states the voxel of the layer's own grid, whatever the transform.
  for (const v of seen.at?.voxel ?? [-1]) expect(v).toBeGreaterThan(-0.5);
  expect(seen.sizes.filter((count) => count === 0)).toHaveLength(3);
  for (const count of seen.sizes.filter((each) => each !== 0)) expect(count).toBeGreaterThan(500);
  expect((seen.budget[0] ?? 0) + (seen.budget[1] ?? 0)).toBe(seen.total);
  expect(Math.min(...seen.budget)).toBeGreaterThan(0);
});

test("a hidden layer keeps and fetches nothing, and is shown again unchanged", async ({ page }) => {
  await scenePage(page);
  await open(page);
  await page.evaluate(async () => {
    window.pictures.both = await window.scene.picture();
  });
  const before = await page.evaluate(() => window.scene.viewer.progress?.samplesResident ?? 0);
  const hidden = await page.evaluate(async () => {
    const { viewer, picture } = window.scene;
    const [large, small] = viewer.layers;
    if (!small || !large) throw new Error("no layers");
    small.visible = false;
    window.pictures.large = await picture();
    const own = large.progress?.samplesResident;
    return { samples: viewer.progress?.samplesResident ?? 0, own, info: small.info !== null };
  });
  expect(hidden.samples).toBe(hidden.own);
  expect(hidden.samples).toBeLessThan(before);
  expect(hidden.info).toBe(true);
  const urls: string[] = [];
  page.on("request", (request) => urls.push(request.url()));
  await page.evaluate(async () => {
    const { viewer, picture, surface } = window.scene;
    const [, small] = viewer.layers;
    if (!small || !viewer.camera) throw new Error("no layer");
    small.surfaces = surface(150);
    const { camera } = viewer;
    viewer.setCamera({ ...camera, azimuth: camera.azimuth + 90 });
    await picture();
    viewer.setCamera(camera);
    small.surfaces = surface(100, "#c8553d");
  });
  expect(urls.filter((url) => url.includes("bucky"))).toEqual([]);
  const added = await page.evaluate(async () => {
    const { viewer, picture, source } = window.scene;
    const third = await viewer.addLayer(source("mandelbulb"), { name: "third", visible: false });
    await picture();
    return { count: viewer.layers.length, info: third.info };
  });
  expect(added).toEqual({ count: 3, info: null });
  expect(urls.filter((url) => url.includes("mandelbulb"))).toEqual([]);
  const differing = await page.evaluate(async () => {
    const { viewer, picture } = window.scene;
    const [, small] = viewer.layers;
    if (small) small.visible = true;
    window.pictures.again = await picture();
    return window.differing("both", "again");
  });
  expect(differing).toBe(0);
});

test("parts of one volume change together", async ({ page }) => {
  await scenePage(page);
  const seen = await page.evaluate(async () => {
    const { viewer, source, surface } = window.scene;
    const options = { partOf: "whole", surfaces: surface(100) };
    const a = await viewer.addLayer(source("bucky"), { ...options, name: "a" });
    const b = await viewer.addLayer(source("marschner_lobb"), { ...options, name: "b" });
    const other = await viewer.addLayer(source("bucky"), { surfaces: surface(90), name: "c" });
    const all = [a, b, other];
    b.surfaces = surface(120, "#ff0000");
    const isovalues = all.map(({ surfaces }) => surfaces.map(({ isovalue }) => isovalue));
    a.transform = [1, 0, 0, 5, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];
    const moved = all.map(({ transform }) => transform[3]);
    a.visible = false;
    const visible = all.map((layer) => layer.visible);
    a.name = "first";
    return { isovalues, moved, visible, names: all.map(({ name }) => name) };
  });
  expect(seen).toEqual({
    isovalues: [[120], [120], [90]],
    moved: [5, 5, 0],
    visible: [false, false, true],
    names: ["first", "b", "c"],
  });
});

test("layers have an order and groups, which do not change the picture", async ({ page }) => {
  await scenePage(page);
  await open(page);
  const seen = await page.evaluate(async () => {
    const { viewer, picture, events } = window.scene;
    const [large, small] = viewer.layers;
    if (!small || !large) throw new Error("no layers");
    // The box cuts the first half of the large volume, which is the first one of the scene.
    viewer.setClip({ ...viewer.clip, low: [0.5, 0, 0] });
    window.pictures.before = await picture();
    events.length = 0;
    viewer.moveLayer(small, 0);
    viewer.moveLayer(small, 0);
    small.group = "molecules";
    window.pictures.after = await picture();
    const wrong = (() => {
      try {
        viewer.moveLayer(small, 2);
        return "moved";
      } catch (error) {
        return (error as Error).name;
      }
    })();
    const names = viewer.layers.map(({ name }) => name);
    const isFirst = viewer.info === large.info;
    const differing = window.differing("before", "after");
    const costs = [large, small].map((layer) => layer.bytesOf(100));
    const first = viewer.bytesOf(100);
    const group = small.group;
    small.visible = false;
    const hidden = [small.bytesOf(100), small.storeAccess, small.quantizedIsovalue(100)];
    return { names, isFirst, differing, wrong, costs, first, group, hidden, events: [...events] };
  });
  expect(seen.names).toEqual(["small", "large"]);
  expect(seen.isFirst).toBe(true);
  expect(seen.differing).toBe(0);
  expect(seen.wrong).toBe("RangeError");
  expect(seen.group).toBe("molecules");
  expect(seen.costs[0]).toBe(seen.first);
  expect(seen.costs[0]).toBeGreaterThan(0);
  expect(seen.costs[1]).toBeGreaterThan(0);
  expect(seen.costs[1]).not.toBe(seen.first);
  expect(seen.hidden).toEqual([undefined, undefined, undefined]);
  expect(seen.events.slice(0, 2)).toEqual(["move small 0", "change group"]);
});

test("a removed layer disappears from the picture, and its memory is freed", async ({ page }) => {
  await scenePage(page);
  await open(page);
  const seen = await page.evaluate(async () => {
    const { viewer, picture, events } = window.scene;
    await picture();
    const [large, small] = viewer.layers;
    if (!small || !large) throw new Error("no layers");
    small.visible = false;
    window.pictures.large = await picture();
    small.visible = true;
    await picture();
    events.length = 0;
    small.remove();
    small.remove();
    window.pictures.removed = await picture();
    const after = {
      samples: viewer.progress?.samplesResident,
      own: large.progress?.samplesResident,
    };
    // The first layer may be removed, too. The next one is then the first.
    const next = await viewer.addLayer(small.source, { name: "next" });
    large.remove();
    window.pictures.next = await picture();
    const isFirst = viewer.info === next.info && viewer.layers[0] === next;
    next.remove();
    return {
      ...after,
      differing: window.differing("large", "removed"),
      isFirst,
      left: viewer.layers.length,
      info: viewer.info,
      events: [...events],
    };
  });
  expect(seen.samples).toBe(seen.own);
  // The range of depths, and how far shadows reach, follow the layers.
  expect(seen.differing).toBeLessThan(50);
  expect(seen.isFirst).toBe(true);
  expect(seen.left).toBe(0);
  expect(seen.info).toBe(null);
  expect(seen.events).toEqual(["remove small", "add next", "remove large", "remove next"]);
});

test("a store that is missing or fails does not affect the others", async ({ page }) => {
  await scenePage(page);
  await open(page);
  const seen = await page.evaluate(async () => {
    const { viewer, picture, source, events } = window.scene;
    window.pictures.both = await picture();
    events.length = 0;
    const failure = await viewer.addLayer(source("no_such_volume"), { name: "missing" }).then(
      () => "added",
      (error: unknown) => (error as StreamModule.StreamError).kind,
    );
    const flat = await viewer.addLayer(source("bucky"), { transform: [] }).then(
      () => "added",
      (error: unknown) => (error as Error).name,
    );
    const late = await viewer.addLayer(source("no_such_volume"), { name: "late", visible: false });
    late.visible = true;
    while (!events.some((event) => event.startsWith("failed"))) {
      await new Promise((next) => setTimeout(next, 20));
    }
    const isLateVisible = late.visible;
    late.remove();
    window.pictures.after = await picture();
    const { layers, progress, isBusy } = viewer;
    const state = { count: layers.length, complete: progress?.complete, isBusy };
    const differing = window.differing("both", "after");
    return { failure, flat, isLateVisible, differing, events: [...events], ...state };
  });
  expect(seen.failure).toBe("not-found");
  expect(seen.flat).toBe("RangeError");
  expect(seen.isLateVisible).toBe(false);
  expect(seen.events).toEqual([
    "add late",
    "change visible",
    "failed late",
    "change visible",
    "remove late",
  ]);
  expect(seen).toMatchObject({ count: 2, complete: true, isBusy: false });
  expect(seen.differing).toBe(0);
});

test("a store whose chunks cannot be fetched is named, and the others become complete", async ({
  page,
}) => {
  await scenePage(page);
  // The header and the directory arrive, but no chunks finer than the coarse levels.
  await page.route(
    ({ pathname, search }) => pathname.includes("bucky") && /chunks/.test(pathname + search),
    (route) => route.abort(),
  );
  await open(page);
  const seen = await page.evaluate(async () => {
    const { viewer, events } = window.scene;
    const [large, small] = viewer.layers;
    if (!large || !small) throw new Error("no layers");
    const isSettled = () =>
      large.progress?.complete && small.progress?.fault && events.includes("failed small");
    while (!isSettled()) await new Promise((next) => setTimeout(next, 20));
    const fault = viewer.progress?.fault?.kind;
    const isComplete = viewer.progress?.complete;
    small.remove();
    while (viewer.isBusy) await new Promise((next) => setTimeout(next, 20));
    const errors = events.filter((event) => event.startsWith("error"));
    const { progress } = viewer;
    return { fault, isComplete, errors, after: progress?.complete, end: progress?.fault };
  });
  expect(seen.fault).toBe("unreachable");
  expect(seen).toMatchObject({ isComplete: false, errors: [], after: true, end: null });
});

test("a transform moves a layer without fetching it again", async ({ page }) => {
  await scenePage(page);
  await open(page);
  const before = await page.evaluate(async () => {
    const { viewer, picture } = window.scene;
    window.pictures.before = await picture();
    return viewer.pick(150, 150);
  });
  const urls: string[] = [];
  page.on("request", (request) => urls.push(request.url()));
  const after = await page.evaluate(async () => {
    const { viewer, picture } = window.scene;
    const [, small] = viewer.layers;
    if (!small?.info) throw new Error("no layer");
    const old = small.transform;
    const step = 0.75 * (small.transform[0] ?? 1);
    const moved = old.with(3, (old[3] ?? 0) + 8 * step);
    small.transform = moved;
    const bytes = viewer.progress?.bytesFetched;
    window.pictures.moved = await picture();
    const differing = window.differing("before", "moved");
    small.transform = old;
    window.pictures.back = await picture();
    return {
      differing,
      back: window.differing("before", "back"),
      bytes: [bytes, viewer.progress?.bytesFetched],
      at: viewer.pick(150, 150),
    };
  });
  expect(after.differing).toBeGreaterThan(500);
  expect(after.back).toBe(0);
  after.at?.position.forEach((number, i) => {
    expect(number).toBeCloseTo(before?.position[i] ?? Number.NaN, 1);
  });
  // Neither the header nor resident chunks are requested.
  expect(urls.filter((url) => /bucky\/?$/.test(url))).toEqual([]);
});

test("after the context was lost, and when another volume is opened", async ({ page }) => {
  await scenePage(page);
  await open(page);
  const seen = await page.evaluate(async () => {
    const { viewer, picture, events, source, surface } = window.scene;
    window.pictures.both = await picture();
    const ids = viewer.layers.map(({ id }) => id);
    const idle: unknown[] = [];
    viewer.on("busy", (isBusy) => isBusy || idle.push(viewer.progress?.state));
    const loss = viewer.canvas.getContext("webgl2")?.getExtension("WEBGL_lose_context");
    const restored = new Promise<void>((resolve) => {
      viewer.on("context", (state) => state === "restored" && resolve());
    });
    loss?.loseContext();
    await new Promise((next) => setTimeout(next, 100));
    loss?.restoreContext();
    await restored;
    window.pictures.restored = await picture();
    const isSame = viewer.layers.every(({ id }, i) => id === ids[i]);
    events.length = 0;
    await viewer.open(source("bucky"), { surfaces: surface(100) });
    await picture();
    const differing = window.differing("both", "restored");
    return { isSame, differing, idle, events: [...events], count: viewer.layers.length };
  });
  expect(seen.isSame).toBe(true);
  expect(new Set(seen.idle), "the viewer is idle only when the picture is complete").toEqual(
    new Set(["complete"]),
  );
  expect(seen.differing).toBe(0);
  expect(seen.events).toEqual(["remove large", "remove small", "add ", "opened"]);
  expect(seen.count).toBe(1);
});
