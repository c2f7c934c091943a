// Files of this device: dropped from the system, built in the page, kept, removed.
import { mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { expect, type Page, test } from "@playwright/test";
import { loadCore } from "../../web/core/index.ts";
import { dicomSlice } from "../support/dicom_files.ts";
import { tiffOf } from "../support/tiff_files.ts";
import { zipOf } from "../support/zip_files.ts";
import { drop } from "./support/drop.ts";
import { refusals } from "./support/policy.ts";
import { demoFolder, type RunningServer, serve } from "./support/server.ts";
import { complete } from "./support/view.ts";

const nrrd = readFileSync(`${demoFolder}/bucky.nrrd`);
const voxels = nrrd.subarray(nrrd.indexOf("\n\n") + 2);
let server: RunningServer;
let folder: string;
let raw: string;

test.beforeAll(async () => {
  server = await serve([demoFolder]);
  folder = mkdtempSync(join(tmpdir(), "isosplat-device-"));
  raw = join(folder, "bucky.raw");
  writeFileSync(raw, voxels);
});
test.afterAll(async () => {
  await server.stop();
  rmSync(folder, { recursive: true, force: true });
});

async function openStartPage(page: Page): Promise<void> {
  await page.goto(server.url);
  await expect(page.locator(".device-drop")).toBeVisible();
}

const build = (page: Page) => page.getByRole("button", { name: "Build the store" }).click();
const kept = (page: Page) => page.locator(".device-card");

test("a dropped store opens, and is kept on request", async ({ page }) => {
  await openStartPage(page);
  await drop(page, [resolve(demoFolder, "bucky.isosplat")]);
  await complete(page);
  await expect(page).toHaveURL(/src=device%3A[0-9a-f]{32}.*isovalue=/);
  await page.getByRole("button", { name: "Save this volume" }).click();
  await page.getByRole("button", { name: "Keep on this device" }).click();
  await expect(page.getByText("Keep on this device: done")).toBeVisible();
  await page.reload();
  await complete(page);
  await openStartPage(page);
  await expect(kept(page)).toHaveCount(1);
  await expect(kept(page)).toContainText("128 × 128 × 128");
  await page.getByRole("button", { name: "Remove bucky from this device" }).click();
  await kept(page).getByRole("button", { name: "Remove", exact: true }).click();
  await expect(kept(page)).toHaveCount(0);
});

test("an NRRD file becomes the program's store", async ({ page }) => {
  await openStartPage(page);
  await drop(page, [resolve(demoFolder, "bucky.nrrd")]);
  await complete(page);
  const core = await loadCore();
  const program = core.openStore(readFileSync(join(demoFolder, "bucky.isosplat")));
  const { searchParams } = new URL(page.url());
  expect(searchParams.get("src")).toBe(`device:${program.info.contentId}`);
  program.close();
});

test("a TIFF stack becomes the store of its voxels", async ({ page }) => {
  const stack = join(folder, "stack.tif");
  const form = { width: 128, height: 128, bits: 8, format: 1, compression: 8 } as const;
  writeFileSync(stack, tiffOf(form, voxels));
  await openStartPage(page);
  await drop(page, [stack]);
  await complete(page);
  await expect(page.locator(".volume-name")).toHaveText("stack");
  await openStartPage(page);
  await expect(kept(page)).toContainText("128 × 128 × 128");
});

test("a ZIP opens like its contents", async ({ page }) => {
  const [scan, series, cut] = ["scan.zip", "series.zip", "cut.zip"].map((name) =>
    join(folder, name),
  ) as [string, string, string];
  const zip = zipOf([
    { name: "read me.txt", content: "not a volume" },
    { name: "in/bucky.nrrd", content: nrrd },
  ]);
  writeFileSync(scan, zip);
  writeFileSync(cut, zip.subarray(0, 5000));
  const slices = Array.from({ length: 12 }, (_, z) => ({
    name: `ct/${z}.dcm`,
    content: dicomSlice(new Uint16Array(64).fill(40 * z), 8, z),
  }));
  writeFileSync(series, zipOf(slices));
  await openStartPage(page);
  await drop(page, [cut]);
  await expect(page.getByRole("alert")).toContainText("cut.zip: it is no ZIP, or incomplete");
  await drop(page, [scan]);
  await complete(page);
  const core = await loadCore();
  const program = core.openStore(readFileSync(join(demoFolder, "bucky.isosplat")));
  const { searchParams } = new URL(page.url());
  expect(searchParams.get("src")).toBe(`device:${program.info.contentId}`);
  program.close();
  await drop(page, [series]);
  await page.getByRole("button", { name: "Open instead" }).click();
  await expect(page.locator(".volume-name")).not.toHaveText("bucky");
  await complete(page);
  await openStartPage(page);
  await expect(kept(page)).toHaveCount(2);
  await expect(kept(page).first()).toContainText("8 × 8 × 12");
});

test("of several volumes, one is chosen", async ({ page }) => {
  await openStartPage(page);
  await drop(
    page,
    ["bucky.nrrd", "marschner_lobb.nrrd"].map((name) => resolve(demoFolder, name)),
  );
  await page
    .getByRole("button", { name: /marschner_lobb/ })
    .last()
    .click();
  await complete(page);
  await expect(page.locator(".volume-name")).toHaveText("marschner_lobb");
});

test("of an HDF5 file with several datasets, one is chosen", async ({ page }) => {
  await openStartPage(page);
  await drop(page, [resolve("tests/native/hdf5/several.h5")]);
  await page.getByRole("button", { name: "several.h5 · /a/b/long" }).last().click();
  await complete(page);
  await openStartPage(page);
  await expect(kept(page)).toContainText("5 × 6 × 7");
});

test("after a reload, the page asks for the file of a store that was not kept", async ({
  page,
}) => {
  await openStartPage(page);
  await drop(page, [resolve(demoFolder, "bucky.isosplat")]);
  await complete(page);
  await page.reload();
  await expect(page.getByRole("alert")).toContainText("open its file again");
});

test("raw voxels in a folder become the program's store, which is kept", async ({ page }) => {
  const scan = join(folder, "scan");
  mkdirSync(scan, { recursive: true });
  writeFileSync(join(scan, "notes.txt"), "not a volume");
  writeFileSync(join(scan, "head.raw"), voxels);
  await openStartPage(page);
  await drop(page, [scan]);
  await build(page);
  await complete(page);
  const id = new URL(page.url()).searchParams.get("src");
  await openStartPage(page);
  await expect(kept(page).locator("a")).toHaveAttribute("href", `?src=${id}`);
  // The same file again: nothing is built.
  await page.evaluate(() => {
    const { Worker: Plain } = window;
    window.Worker = class extends Plain {
      constructor(url: string | URL, options?: WorkerOptions) {
        if (/build_worker|encode_worker/.test(String(url))) throw new Error("built again");
        super(url, options);
      }
    };
  });
  await drop(page, [scan]);
  await build(page);
  await complete(page);
  expect(new URL(page.url()).searchParams.get("src")).toBe(id);
});

test("a dropped volume replaces the open one", async ({ page }) => {
  await page.goto(`${server.url}?volume=marschner_lobb`);
  await complete(page);
  await expect(page.locator("wa-slider").first()).toBeVisible();
  await page.waitForFunction(() => document.querySelector("link[href*=device_files]") !== null);
  await drop(page, [resolve(demoFolder, "bucky.isosplat")]);
  await page.getByRole("button", { name: "Open instead" }).click();
  await expect(page.locator(".volume-name")).toHaveText("bucky");
  await complete(page);
  await expect(page).toHaveURL(/src=device/);
});

test("a dropped volume is added to the picture of the open one", async ({ page }) => {
  await page.goto(`${server.url}?volume=marschner_lobb`);
  await complete(page);
  await page.waitForFunction(() => document.querySelector("link[href*=device_files]") !== null);
  const names = page.locator(".layer-name");
  await drop(page, [resolve(demoFolder, "bucky.nrrd")]);
  await page.getByRole("button", { name: "Add to the picture" }).click();
  await expect(names).toHaveText(["marschner_lobb", "bucky"]);
  await complete(page);
  await expect(page.locator(".volume-name")).toHaveText("marschner_lobb");
  await expect(page).toHaveURL(/volume=marschner_lobb.*layer=src:device:[0-9a-f]{32};/);
  // The added volume is kept on this device, so that the link opens it again.
  await page.reload();
  await complete(page);
  await expect(names).toHaveText(["marschner_lobb", "bucky"]);
  await drop(page, [resolve(demoFolder, "bucky.isosplat")]);
  await page.getByRole("dialog").getByRole("button", { name: "Close" }).click();
  await expect(page.locator(".task-card")).toHaveCount(0);
  await expect(names).toHaveCount(2);
});

test("a hundred unrelated files: one message", async ({ page }) => {
  const many = Array.from({ length: 100 }, (_, i) => join(folder, `letter ${i}.txt`));
  for (const path of many) writeFileSync(path, "dear");
  await openStartPage(page);
  await drop(page, many);
  const message = page.locator(".task-card [role=alert]");
  await expect(message).toHaveCount(1);
  await expect(message).toContainText("found 100 files");
  await expect(page.getByRole("alert")).toHaveCount(1);
  await page.locator(".task-card").getByRole("button", { name: "Close" }).click();
  await expect(page.locator(".task-card")).toHaveCount(0);
});

test("a layout that does not fit is refused before anything is read", async ({ page }) => {
  await openStartPage(page);
  await drop(page, [raw]);
  await page.getByLabel("along z").fill("129");
  await expect(page.getByText("expected 2113536 bytes, found a file of 2097152")).toBeVisible();
  await expect(page.getByRole("button", { name: "Build the store" })).toBeDisabled();
});

/** Writes files into the folder of kept stores. */
const writeKept = (page: Page, files: Record<string, string>) =>
  page.evaluate(async (contents) => {
    const root = await navigator.storage.getDirectory();
    const stores = await root.getDirectoryHandle("isosplat-stores", { create: true });
    for (const [name, text] of Object.entries(contents)) {
      const file = await stores.getFileHandle(name, { create: true });
      const writing = await file.createWritable();
      await writing.write(text);
      await writing.close();
    }
  }, files);

/** The names of the files in the folder of kept stores. */
const keptFiles = (page: Page) =>
  page.evaluate(async () => {
    const root = await navigator.storage.getDirectory();
    const stores = await root.getDirectoryHandle("isosplat-stores", { create: true });
    const names: string[] = [];
    for await (const name of stores.keys()) names.push(name);
    return names.sort();
  });

const someId = "0123456789abcdef".repeat(2);

test("what an interrupted write has left is removed, which the page says", async ({ page }) => {
  await openStartPage(page);
  await writeKept(page, { [`${someId}.isosplat`]: "half", [`${someId}.incomplete`]: "" });
  await openStartPage(page);
  await expect(page.locator(".device [role=status]")).toContainText("was not kept completely");
  expect(await keptFiles(page)).toEqual([]);
  await expect(kept(page)).toHaveCount(0);
  await openStartPage(page);
  await expect(page.locator(".device [role=status]")).toHaveCount(0);
});

test("what another tab is writing is neither listed nor removed", async ({ page, context }) => {
  await openStartPage(page);
  const files = { [`${someId}.isosplat`]: "half", [`${someId}.incomplete`]: "" };
  await writeKept(page, files);
  await page.evaluate((id) => {
    void navigator.locks.request(`isosplat-store-${id}`, () => new Promise(() => {}));
  }, someId);
  const other = await context.newPage();
  await openStartPage(other);
  await other.waitForTimeout(300);
  expect(await keptFiles(other)).toEqual(Object.keys(files).sort());
  await expect(kept(other)).toHaveCount(0);
  await page.close();
  await openStartPage(other);
  await expect.poll(() => keptFiles(other)).toEqual([]);
});

test("a store that cannot be read stays, is listed, and is removed on the visitor's word", async ({
  page,
}) => {
  await openStartPage(page);
  // Not marked: perhaps only its description is damaged.
  await writeKept(page, { [`${someId}.isosplat`]: "a store", [`${someId}.json`]: "{" });
  await openStartPage(page);
  await expect(kept(page)).toContainText("Cannot be read");
  await page.goto(`${server.url}?src=device:${someId}`);
  await expect(page.locator(".device [role=alert]")).toBeVisible();
  expect(await keptFiles(page)).toEqual([`${someId}.isosplat`, `${someId}.json`]);
  await openStartPage(page);
  await kept(page)
    .getByRole("button", { name: /^Remove/ })
    .click();
  await kept(page).getByRole("button", { name: "Keep it" }).click();
  await kept(page)
    .getByRole("button", { name: /^Remove/ })
    .click();
  await kept(page).getByRole("button", { name: "Remove", exact: true }).click();
  await expect(kept(page)).toHaveCount(0);
  expect(await keptFiles(page)).toEqual([]);
});

test("a store stays while its files cannot be read for a time, and a full disk cannot replace it", async ({
  page,
  context,
}) => {
  await openStartPage(page);
  await drop(page, [raw]);
  await build(page);
  await complete(page);
  await expect.poll(async () => (await keptFiles(page)).length).toBe(2);
  const files = await keptFiles(page);

  const other = await context.newPage();
  await other.addInitScript(() => {
    FileSystemFileHandle.prototype.getFile = () =>
      Promise.reject(new DOMException("the disk is busy", "NotReadableError"));
    FileSystemFileHandle.prototype.createWritable = () =>
      Promise.reject(new DOMException("full", "QuotaExceededError"));
  });
  await openStartPage(other);
  await expect(kept(other)).toContainText("Cannot be read: the disk is busy");
  await drop(other, [raw]);
  await build(other);
  await complete(other);
  await expect(other.locator(".task-card [role=alert]")).toContainText("of room for this site");
  expect(await keptFiles(page)).toEqual(files);
  await openStartPage(page);
  await expect(kept(page)).toContainText("128 × 128 × 128");
});

test("what the browser does not remove is named, stays marked, and is removed later", async ({
  page,
}) => {
  await openStartPage(page);
  await writeKept(page, { [`${someId}.isosplat`]: "a store", [`${someId}.json`]: "{" });
  await openStartPage(page);
  await page.evaluate(() => {
    const { removeEntry } = FileSystemDirectoryHandle.prototype;
    FileSystemDirectoryHandle.prototype.removeEntry = function (name, ...options) {
      if (!name.endsWith(".isosplat")) return removeEntry.call(this, name, ...options);
      return Promise.reject(new DOMException("it is locked", "NoModificationAllowedError"));
    };
  });
  await kept(page)
    .getByRole("button", { name: /^Remove/ })
    .click();
  await kept(page).getByRole("button", { name: "Remove", exact: true }).click();
  await expect(page.locator(".device [role=alert]")).toContainText("did not remove");
  expect(await keptFiles(page)).toEqual([`${someId}.incomplete`, `${someId}.isosplat`]);
  await openStartPage(page);
  await expect.poll(() => keptFiles(page)).toEqual([]);
});

test("a volume that is kept again after an interrupted write stays", async ({ page }) => {
  await openStartPage(page);
  await drop(page, [raw]);
  await build(page);
  await complete(page);
  await expect.poll(async () => (await keptFiles(page)).length).toBe(2);
  const [store = ""] = await keptFiles(page);
  await writeKept(page, { [store]: "half", [store.replace("isosplat", "incomplete")]: "" });
  await drop(page, [raw]);
  await page.getByRole("button", { name: "Open instead" }).click();
  await build(page);
  await complete(page);
  await expect
    .poll(() => keptFiles(page))
    .toEqual([store, store.replace(".isosplat", ".json")].sort());
});

test("the browser is asked not to remove what is kept", async ({ page }) => {
  await page.addInitScript(() => {
    navigator.storage.persisted = async () => sessionStorage.getItem("granted") !== null;
    navigator.storage.persist = async () => {
      sessionStorage.setItem("granted", "");
      return true;
    };
  });
  await openStartPage(page);
  await expect(page.locator(".device")).not.toContainText("until you remove them");
  await drop(page, [raw]);
  await build(page);
  await complete(page);
  await page.goBack();
  await expect(page.locator(".device")).toContainText("until you remove them");
});

test("two tabs that open the same file build it once", async ({ page, context }) => {
  const other = await context.newPage();
  await Promise.all([openStartPage(page), openStartPage(other)]);
  for (const tab of [page, other]) await drop(tab, [raw]);
  for (const tab of [page, other]) await build(tab);
  for (const tab of [page, other]) await complete(tab);
  await openStartPage(page);
  await expect(kept(page)).toHaveCount(1);
});

test("without a private file system, or without room, the volume opens nevertheless", async ({
  page,
}) => {
  await page.addInitScript(() => {
    navigator.storage.estimate = async () => ({ quota: 1000, usage: 0 });
  });
  await openStartPage(page);
  await drop(page, [raw]);
  await build(page);
  await complete(page);
  await expect(page.locator(".task-card [role=alert]")).toContainText("of room for this site");
  await expect(page.locator(".task-card [role=alert]")).toContainText("Open, but not kept");
  await openStartPage(page);
  await expect(kept(page)).toHaveCount(0);
});

test("a disk that becomes full during writing: a message, and no incomplete store is kept", async ({
  page,
}) => {
  await page.addInitScript(() => {
    navigator.storage.estimate = async () => ({ quota: 1e12, usage: 0 });
  });
  await openStartPage(page);
  const session = await page.context().newCDPSession(page);
  const { origin } = new URL(server.url);
  await session.send("Storage.overrideQuotaForOrigin", { origin, quotaSize: 500_000 });
  await drop(page, [resolve(demoFolder, "bucky.nrrd")]);
  await complete(page);
  await expect(page.locator(".task-card [role=alert]")).toContainText(
    /Expected 1\.4 MB of room for this site on this device, found less: .* until this tab is closed/,
  );
  expect(await keptFiles(page)).toEqual([]);
});

test("a cancelled build ends its workers, keeps nothing, and can be started again", async ({
  page,
}) => {
  await page.addInitScript(() => {
    const { Worker: Plain } = window;
    // Blocks are never encoded, so the build runs until it is cancelled.
    window.Worker = class extends Plain {
      constructor(url: string | URL, options?: WorkerOptions) {
        super(url, options);
        const { held = true } = window as { held?: boolean };
        if (held && /encode_worker/.test(String(url))) this.postMessage = () => {};
      }
    };
  });
  await openStartPage(page);
  const card = page.locator(".task-card");
  await drop(page, [resolve(demoFolder, "bucky.nrrd")]);
  await expect(card).toContainText("Building bucky");
  await expect.poll(() => page.workers().some((worker) => /encode/.test(worker.url()))).toBe(true);
  await drop(page, [raw]);
  await expect(card).toContainText("Not opened: what was dropped meanwhile");
  await expect(card).toContainText("Building bucky");
  await card.getByRole("button", { name: "Cancel" }).click();
  await expect(card).toHaveCount(0);
  await expect.poll(() => page.workers().length).toBe(0);
  await expect(page.locator(".device-drop")).toBeVisible();
  await expect(kept(page)).toHaveCount(0);
  await page.evaluate(() => Object.assign(window, { held: false }));
  await drop(page, [resolve(demoFolder, "bucky.nrrd")]);
  await complete(page);
  await expect(page.locator(".volume-name")).toHaveText("bucky");
});

test("pasted files open like dropped ones", async ({ page }) => {
  await openStartPage(page);
  const small = readFileSync(`${demoFolder}/marschner_lobb.nrrd`).toString("base64");
  await page.evaluate(async (data) => {
    const bytes = await (await fetch(`data:application/octet-stream;base64,${data}`)).blob();
    const clipboardData = new DataTransfer();
    clipboardData.items.add(new File([bytes], "pasted.nrrd"));
    document.body.dispatchEvent(new ClipboardEvent("paste", { clipboardData, bubbles: true }));
  }, small);
  await complete(page);
  await expect(page.locator(".volume-name")).toHaveText("pasted");
});

test("after a file was opened, the browser refuses requests to other origins", async ({ page }) => {
  const outside: string[] = [];
  page.on("request", (request) => {
    const isOwn = request.url().startsWith(server.url) || /^(data|blob):/.test(request.url());
    if (!isOwn) outside.push(request.url());
  });
  const refused = refusals(page);
  await page.addInitScript(() => {
    // The workers of the build are kept after it, so that the test can query them.
    window.Worker.prototype.terminate = () => {};
  });
  await openStartPage(page);
  await drop(page, [raw]);
  await build(page);
  await complete(page);
  expect(outside).toEqual([]);
  expect(refused).toEqual([]);
  const upload = async (): Promise<string> => {
    const blocked = new Promise<string>((resolve) =>
      globalThis.addEventListener("securitypolicyviolation", (event) =>
        resolve((event as SecurityPolicyViolationEvent).effectiveDirective),
      ),
    );
    await fetch("http://127.0.0.2:9/", { method: "POST", body: "voxels" }).catch(() => {});
    return blocked;
  };
  expect(await page.evaluate(upload)).toBe("connect-src");
  expect(refused.length).toBeGreaterThan(0);
  // The workers that find the volume, read it, encode its store, and decode it.
  const workers = page.workers();
  expect(workers.length).toBeGreaterThanOrEqual(4);
  for (const worker of workers) expect(await worker.evaluate(upload)).toBe("connect-src");
});
