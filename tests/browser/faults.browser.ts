// The page's messages and recovery after faults of a file, a host or the graphics driver. The
// server, nginx and the losses of the WebGL context are real.
import {
  copyFileSync,
  mkdtempSync,
  readFileSync,
  renameSync,
  rmSync,
  truncateSync,
  writeFileSync,
} from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { expect, type Page, test } from "@playwright/test";
import { FaultProxy } from "../support/fault_proxy.ts";
import { type Nginx, nginx } from "../support/nginx.ts";
import { damagedChunks } from "./support/damage.ts";
import { loseContext, restoreContext, saveData, slideTo } from "./support/in_page.ts";
import { demoFolder, type RunningServer, serve } from "./support/server.ts";
import { compare, complete, savedPicture, settled } from "./support/view.ts";

test.use({ viewport: { width: 800, height: 500 } });
// A store that was read as a whole would not show the faults of its source.
test.beforeEach(({ page }) => page.addInitScript(saveData));
// Slow retries take long, more so on a slow machine.
test.describe.configure({ timeout: 240_000 });
/** Time for two slow retries on a slow machine. */
const slow = 60_000;
const bucky = join(demoFolder, "bucky.isosplat");
const mandelbulb = join(demoFolder, "mandelbulb.isosplat");
const lobb = join(demoFolder, "marschner_lobb.isosplat");

let folder: string;
let server: RunningServer;
let host: Nginx;
let number = 0;

test.beforeAll(async () => {
  folder = mkdtempSync(join(tmpdir(), "isosplat-faults-"));
  server = await serve([folder]);
  host = await nginx({ folders: [folder] });
});
test.afterAll(async () => {
  await server.stop();
  await host.stop();
  rmSync(folder, { recursive: true, force: true });
});

const path = (name: string): string => join(folder, `${name}.isosplat`);

/** Adds a changed store to the server under a new name, by renaming a complete file. */
async function put(
  from: string,
  change: (bytes: Buffer) => Buffer = (bytes) => bytes,
  name = `store-${++number}`,
): Promise<string> {
  const before = await contentId(name);
  writeFileSync(`${path(name)}.part`, change(readFileSync(from)));
  renameSync(`${path(name)}.part`, path(name));
  await expect.poll(() => contentId(name)).not.toBe(before);
  return name;
}

/** The server's entry for the volume; for a broken store, its status. */
async function contentId(name: string): Promise<string> {
  const answer = await fetch(`${server.url}v1/volumes/${name}`);
  const entry = (await answer.json()) as { contentId?: string; status?: string };
  return entry.contentId ?? entry.status ?? "";
}

const onServer = (name: string): string => `${server.url}?volume=${name}`;
const onHost = (name: string, of: Nginx = host): string =>
  `${server.url}?src=${encodeURIComponent(`${of.url}${name}.isosplat`)}`;

const slide = (page: Page, value: number): Promise<void> => page.evaluate(slideTo, value);

/** Expects that nothing covers the picture, and that there is no message beside it. */
async function expectNoWord(page: Page): Promise<void> {
  await expect(page.getByRole("alert")).toHaveCount(0);
  await expect(page.locator(".banner")).toHaveCount(0);
  await expect(page.locator("wa-spinner")).toHaveCount(0);
}

test.describe("the graphics context is lost", () => {
  test("and the view moves while the volume is opened again: the picture matches the address", async ({
    page,
  }) => {
    const name = await put(bucky);
    const proxy = new FaultProxy(server.url);
    await proxy.start();
    try {
      const distance = (): number =>
        Number(new URL(page.url()).searchParams.get("camera")?.split(",")[2]);
      await page.goto(`${proxy.url}/?volume=${name}&kind=exact&camera=30,20,400,63.5,63.5,63.5`);
      await complete(page);
      await settled(page);
      proxy.requests.length = 0;
      proxy.fault = () => ({ kind: "delay", milliseconds: 3000 });
      await page.evaluate(loseContext);
      await page.evaluate(restoreContext);
      await expect.poll(() => proxy.requests.length).toBeGreaterThan(0);
      await page.getByRole("application").focus();
      for (const key of ["+", "+"]) await page.keyboard.press(key);
      expect(proxy.requests.every(({ status }) => status === 0)).toBe(true);
      proxy.fault = () => undefined;
      await complete(page);
      await settled(page);
      expect(distance()).toBeLessThan(350);
      const picture = await savedPicture(page);
      await page.reload();
      await complete(page);
      await settled(page);
      const { differing, covered } = await compare(page, picture, await savedPicture(page));
      expect(covered).toBeGreaterThan(0.05);
      expect(differing).toBe(0);
    } finally {
      await proxy.stop();
    }
  });

  test("and restored, several times: the same picture, and no message", async ({ page }) => {
    test.setTimeout(300_000);
    const name = await put(bucky);
    // A fixed kind: the automatic one depends on frame times, and edges differ between kinds.
    await page.goto(`${onServer(name)}&kind=exact`);
    await settled(page);
    await complete(page);
    const before = await savedPicture(page);
    for (let round = 0; round < 3; ++round) {
      await page.evaluate(loseContext);
      await expect(page.locator(".banner")).toContainText("took the graphics card away");
      await page.evaluate(restoreContext);
      await complete(page);
      await settled(page);
      await expectNoWord(page);
    }
    const { differing, covered } = await compare(page, await savedPicture(page), before);
    expect(covered).toBeGreaterThan(0.05);
    expect(differing).toBe(0);
  });

  test("while the server fails: the view does not become complete in the meantime", async ({
    page,
  }) => {
    const name = await put(bucky);
    const proxy = new FaultProxy(server.url);
    await proxy.start();
    try {
      await page.goto(`${proxy.url}/?volume=${name}`);
      await complete(page);
      await settled(page);
      proxy.fault = () => ({ kind: "status", status: 500 });
      await page.evaluate(loseContext);
      await expect(page.locator(".status-state")).toHaveText("");
      await page.evaluate(restoreContext);
      await expect(page.getByRole("alert")).toContainText("answers with an error");
      await expect(page.locator(".status-state")).toHaveText("");
      proxy.fault = () => undefined;
      await complete(page, slow);
      await settled(page);
      await expectNoWord(page);
    } finally {
      await proxy.stop();
    }
  });

  test("while data are loading, and before the first data", async ({ page }) => {
    const name = await put(bucky);
    const proxy = new FaultProxy(server.url);
    await proxy.start();
    proxy.fault = (path) =>
      /\/(batch|chunks|file|bootstrap)/.test(path) ? { kind: "drip", bytes: 900 } : undefined;
    try {
      await page.goto(`${proxy.url}/?volume=${name}`);
      await page.waitForFunction(() =>
        document.querySelector<HTMLCanvasElement>("canvas.view")?.getContext("webgl2"),
      );
      await page.evaluate(loseContext);
      await page.evaluate(restoreContext);
      await expect(page.locator(".status-samples")).toHaveText(/samples/);
      await page.evaluate(loseContext);
      await page.evaluate(restoreContext);
      proxy.fault = () => undefined;
      await complete(page);
      await settled(page);
      await expectNoWord(page);
    } finally {
      await proxy.stop();
    }
  });
});

test.describe("a store is damaged", () => {
  for (const [where, address] of [
    ["isosplat serve", onServer],
    ["nginx", onHost],
  ] as const) {
    test(`in its chunks, on ${where}: complete except for them`, async ({ page }) => {
      const name = await put(bucky, (bytes) => damagedChunks(bytes, 24));
      const urls: string[] = [];
      page.on("request", (request) => urls.push(request.url()));
      await page.goto(`${address(name)}&isovalue=128&camera=30,20,300,64,64,64`);
      await expect(page.locator(".status-state")).toHaveText(
        /^complete except for \d+ damaged parts?$/,
      );
      await settled(page);
      await expect(page.locator(".banner")).toContainText("The store is damaged");
      await expect(page.locator("wa-spinner")).toHaveCount(0);
      await expect(page.locator(".status-samples")).toHaveText(/samples/);
      // From here on, damaged chunks are retried slowly, one at a time.
      const before = urls.length;
      await page.waitForTimeout(5000);
      expect(urls.length - before).toBeLessThanOrEqual(2);
    });
  }

  test("in its directory: the spinner ends", async ({ page }) => {
    const name = await put(bucky, (bytes) => {
      for (let i = 1; i < 2000; ++i) bytes[bytes.length - i] = 0x55;
      return bytes;
    });
    await page.goto(onHost(name));
    await expect(page.locator("[role=alert], .banner").first()).toContainText("damaged");
    await settled(page);
    await expect(page.locator("wa-spinner")).toHaveCount(0);
  });

  test("in its header", async ({ page }) => {
    const name = await put(bucky, (bytes) => {
      bytes[100] = (bytes[100] ?? 0) ^ 1;
      return bytes;
    });
    for (const address of [onServer(name), onHost(name)]) {
      await page.goto(address);
      await expect(page.getByRole("alert")).toContainText("The store is damaged");
    }
  });

  test("cut short, and empty", async ({ page }) => {
    const short = await put(bucky, (bytes) => bytes.subarray(0, bytes.length - 1000));
    const half = await put(bucky, (bytes) => bytes.subarray(0, bytes.length / 2));
    const empty = await put(bucky, () => Buffer.alloc(0));
    for (const address of [onServer(short), onHost(short), onHost(half), onHost(empty)]) {
      await page.goto(address);
      await expect(page.getByRole("alert")).toContainText("cut short");
      await expect(page.getByRole("alert")).not.toContainText("Range");
      await settled(page);
    }
    await page.goto(onServer(empty));
    await expect(page.getByRole("alert")).toContainText("not a store");
    // When the file is copied again, the page opens it without an action.
    await page.goto(onHost(short));
    await expect(page.getByRole("alert")).toContainText("cut short");
    await put(bucky, (bytes) => bytes, short);
    await complete(page, slow);
    await expectNoWord(page);
  });

  test("cut short while it is open", async ({ page }) => {
    const name = await put(lobb);
    await page.goto(`${onServer(name)}&isovalue=60`);
    await complete(page);
    truncateSync(path(name), 30_000);
    await expect.poll(() => contentId(name)).toBe("truncated");
    await slide(page, 200);
    await expect(page.locator(".banner")).toContainText("cut short", { timeout: slow });
    await settled(page);
    await expect(page.locator(".status-samples")).toHaveText(/samples/);
  });
});

test.describe("a store is", () => {
  for (const [where, address] of [
    ["isosplat serve", onServer],
    ["nginx", onHost],
  ] as const) {
    test(`renamed and renamed back, on ${where}: its message disappears`, async ({ page }) => {
      test.setTimeout(300_000);
      const name = await put(lobb);
      await page.goto(`${address(name)}&isovalue=60`);
      await complete(page);
      renameSync(path(name), `${path(name)}.away`);
      await expect.poll(() => contentId(name)).toBe("not_found");
      await slide(page, 200);
      await expect(page.locator(".banner")).toContainText("No such volume");
      await settled(page);
      renameSync(`${path(name)}.away`, path(name));
      await complete(page, slow);
      await expectNoWord(page);
    });

    test(`replaced under its name, on ${where}: the page opens the new store`, async ({ page }) => {
      test.setTimeout(300_000);
      const name = await put(lobb);
      await page.goto(`${address(name)}&isovalue=60&camera=30,20,40,20,20,20`);
      await complete(page);
      await put(mandelbulb, (bytes) => bytes, name);
      await slide(page, 200);
      await expect(page.locator(".toast")).toContainText("The volume was replaced", {
        timeout: slow,
      });
      await complete(page);
      await settled(page);
      await expectNoWord(page);
      await expect(page.locator(".volume-name")).toContainText(/mandelbulb/i);
      // The camera is reset: the new volume is visible, with background around it.
      const picture = await savedPicture(page);
      const { covered } = await compare(page, picture, picture);
      expect(covered).toBeGreaterThan(0.05);
      expect(covered).toBeLessThan(0.95);
    });
  }

  test("missing at first, then added", async ({ page }) => {
    await page.goto(onHost("late"));
    await expect(page.getByRole("alert")).toContainText("No such volume");
    copyFileSync(bucky, path("late"));
    await complete(page, slow);
    await expectNoWord(page);
  });
});

test("a host without CORS is distinguished from one that does not respond", async ({ page }) => {
  test.setTimeout(300_000);
  const name = await put(bucky);
  const closed = await nginx({ folders: [folder], cors: "none" });
  try {
    await page.goto(onHost(name, closed));
    const message = page.getByRole("alert");
    await expect(message).toContainText("does not let other sites read");
    await expect(message).toContainText("Access-Control-Allow-Origin");
    await expect(message).toContainText("Access-Control-Expose-Headers");
    await settled(page);
  } finally {
    await closed.stop();
  }
  // Now the host does not respond; then it responds with CORS.
  await expect(page.getByRole("alert")).toContainText("does not answer", { timeout: slow });
  const open = await nginx({ folders: [folder], port: Number(new URL(closed.url).port) });
  try {
    await complete(page, slow);
    await expectNoWord(page);
  } finally {
    await open.stop();
  }
});

test("a host whose responses do not expose Content-Range", async ({ page }) => {
  const name = await put(bucky);
  const silent = await nginx({ folders: [folder], cors: "body" });
  try {
    await page.goto(onHost(name, silent));
    await complete(page);
    truncateSync(path(name), 50_000);
    await slide(page, 30);
    await expect(page.locator(".banner")).toContainText("cut short", { timeout: slow });
  } finally {
    await silent.stop();
  }
});

test.describe("the renderer", () => {
  test("aborts: it is replaced", async ({ page }) => {
    test.setTimeout(300_000);
    const name = await put(bucky);
    await page.goto(onServer(name));
    await complete(page);
    await settled(page);
    const before = await savedPicture(page);
    // A trap leaves the instance as unusable as this exception does.
    await page.evaluate(() => {
      const { prototype } = WebGL2RenderingContext;
      const clear = prototype.clearBufferfv;
      prototype.clearBufferfv = () => {
        prototype.clearBufferfv = clear;
        throw new WebAssembly.RuntimeError("unreachable executed");
      };
    });
    await slide(page, 60);
    await expect(page.locator(".status-state")).not.toHaveText(/^complete/);
    await slide(page, 128);
    await complete(page, slow);
    await settled(page);
    await expectNoWord(page);
    await page.reload();
    await complete(page);
    await settled(page);
    expect((await compare(page, await savedPicture(page), before)).covered).toBeGreaterThan(0.05);
  });

  test("fails in JavaScript: a message until the next picture, and no replacement", async ({
    page,
  }) => {
    const name = await put(bucky);
    await page.goto(onServer(name));
    await complete(page);
    await settled(page);
    await page.evaluate(() => {
      const state = window as unknown as { losses: number };
      state.losses = 0;
      document.querySelector("canvas.view")?.addEventListener("webglcontextlost", () => {
        ++state.losses;
      });
      const { prototype } = WebGL2RenderingContext;
      const clear = prototype.clearBufferfv;
      prototype.clearBufferfv = () => {
        throw new TypeError("not a trap");
      };
      (window as unknown as { mend: () => void }).mend = () => {
        prototype.clearBufferfv = clear;
      };
    });
    await page.getByRole("application").focus();
    await page.keyboard.press("ArrowLeft");
    await expect(page.locator(".banner")).toContainText("Something went wrong");
    await page.evaluate(() => (window as unknown as { mend: () => void }).mend());
    await page.keyboard.press("ArrowLeft");
    await complete(page);
    await settled(page);
    await expectNoWord(page);
    expect(await page.evaluate(() => (window as unknown as { losses: number }).losses)).toBe(0);
  });

  test("has no memory for a chunk: a coarser picture and a message", async ({ page }) => {
    await page.addInitScript(() => {
      const { prototype } = WebGL2RenderingContext;
      const state = window as unknown as { isFull: boolean };
      state.isFull = true;
      let isReported = true;
      const { bufferData, getError } = prototype;
      // Like a driver without memory for a buffer of samples.
      prototype.bufferData = function (this: WebGL2RenderingContext, ...args: unknown[]) {
        const [, size] = args;
        if (state.isFull && typeof size === "number" && size >= 1 << 23) isReported = false;
        return (bufferData as (...all: unknown[]) => void).apply(this, args);
      } as typeof bufferData;
      prototype.getError = function (this: WebGL2RenderingContext) {
        const error = getError.call(this);
        if (isReported) return error;
        isReported = true;
        return this.OUT_OF_MEMORY;
      };
    });
    const name = await put(bucky);
    await page.goto(onServer(name));
    await expect(page.locator("[role=alert], .banner").first()).toContainText("memory is full");
    await settled(page);
    await page.evaluate(() => {
      (window as unknown as { isFull: boolean }).isFull = false;
    });
    await page.getByRole("button", { name: "Try again" }).click();
    await complete(page);
    await expectNoWord(page);
  });

  test("a failing occlusion query does not prevent a complete view", async ({ page }) => {
    await page.addInitScript(() => {
      const { prototype } = WebGL2RenderingContext;
      const { getBufferSubData } = prototype;
      let isFirst = true;
      prototype.getBufferSubData = function (this: WebGL2RenderingContext, ...args: unknown[]) {
        if (isFirst) {
          isFirst = false;
          throw new TypeError("the driver returns nothing");
        }
        return (getBufferSubData as (...all: unknown[]) => void).apply(this, args);
      } as typeof getBufferSubData;
    });
    const name = await put(lobb);
    await page.goto(onServer(name));
    await complete(page);
    await settled(page);
  });
});
