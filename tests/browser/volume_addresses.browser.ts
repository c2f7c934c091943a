/** Opens volume files by URLs of other hosts: fetches them, builds and keeps stores, and reopens them. */
import { copyFileSync, mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { expect, type Page, test } from "@playwright/test";
import { loadCore } from "../../web/core/index.ts";
import { FaultProxy } from "../support/fault_proxy.ts";
import { hasNginx, type Nginx, nginx } from "../support/nginx.ts";
import { writeArray, writeGroup } from "../support/zarr.ts";
import { demoFolder, type RunningServer, serve } from "./support/server.ts";
import { complete, settled } from "./support/view.ts";

test.skip(!hasNginx, "needs nginx");

let server: RunningServer;
let host: Nginx;
let folder: string;
let proxy: FaultProxy;

test.beforeAll(async () => {
  folder = mkdtempSync(join(tmpdir(), "isosplat-addresses-"));
  const nrrd = readFileSync(`${demoFolder}/bucky.nrrd`);
  const end = nrrd.indexOf("\n\n") + 2;
  mkdirSync(join(folder, "scan"));
  mkdirSync(join(folder, "voxels"));
  copyFileSync(`${demoFolder}/bucky.nrrd`, join(folder, "bucky.nrrd"));
  writeFileSync(join(folder, "voxels", "bucky.raw"), nrrd.subarray(end));
  const header = nrrd.subarray(0, end - 1).toString();
  writeFileSync(join(folder, "scan", "head.nhdr"), `${header}data file: ../voxels/bucky.raw\n\n`);
  server = await serve([demoFolder]);
  host = await nginx({ folders: [folder] });
});
test.afterAll(async () => {
  await Promise.all([server?.stop(), host?.stop()]);
  rmSync(folder, { recursive: true, force: true });
});
test.beforeEach(async () => {
  proxy = new FaultProxy(host.url);
  await proxy.start();
});
test.afterEach(() => proxy.stop());

const open = (page: Page, address: string) =>
  page.goto(`${server.url}?src=${encodeURIComponent(address)}`);
const message = (page: Page) => page.locator(".task-card [role=alert]");
const kept = (page: Page) => page.locator(".device-card");

test("an address in the start page's field opens, is kept, and is not fetched again", async ({
  page,
}) => {
  const address = `${proxy.url}/bucky.nrrd`;
  await page.goto(server.url);
  await page.getByRole("textbox", { name: "Address of a store or a volume" }).fill(address);
  await page.getByRole("button", { name: "Open", exact: true }).click();
  await complete(page);
  await settled(page);
  const url = new URL(page.url());
  expect(url.searchParams.get("src")).toBe(address);
  expect(url.searchParams.get("isovalue")).not.toBeNull();
  const workers: string[] = [];
  page.on("worker", (worker) => workers.push(worker.url()));
  await page.reload();
  await complete(page);
  expect(workers.filter((worker) => worker.includes("import_worker"))).toEqual([]);
  // The host does not respond, so the page shows the store that it has kept.
  await proxy.stop();
  await page.reload();
  await complete(page);
  await expect(message(page)).toContainText("cannot be reached: this is what was kept");
  const core = await loadCore();
  const program = core.openStore(readFileSync(join(demoFolder, "bucky.isosplat")));
  await page.goto(server.url);
  await expect(kept(page).locator("a")).toHaveAttribute(
    "href",
    `?src=device:${program.info.contentId}`,
  );
  program.close();
});

test("a header fetches the voxels that it names", async ({ page }) => {
  await open(page, `${host.url}scan/head.nhdr`);
  await complete(page);
  await expect(page.locator(".volume-name")).toHaveText("head");
});

test("a download continues after its connection broke", async ({ page }) => {
  proxy.fault = (_, number) => (number === 1 ? { kind: "truncate", bytes: 700_000 } : undefined);
  await open(page, `${proxy.url}/bucky.nrrd`);
  await complete(page);
  // The browser's cache may also request a byte range.
  expect(proxy.requests.length).toBeGreaterThan(1);
});

test("a host without CORS, and a missing file: one message, and the list stays", async ({
  page,
}) => {
  const closed = await nginx({ folders: [folder], cors: "none" });
  try {
    await open(page, `${closed.url}bucky.nrrd`);
    await expect(message(page)).toContainText("Access-Control-Allow-Origin");
    await expect(page.getByRole("heading", { name: "Volumes" })).toBeVisible();
  } finally {
    await closed.stop();
  }
  await open(page, `${host.url}none.nii.gz`);
  await expect(message(page)).toContainText("404");
  await expect(message(page)).toContainText("check the address");
});

test("cancelling ends a fetch", async ({ page }) => {
  proxy.fault = () => ({ kind: "drip", bytes: 100 });
  await open(page, `${proxy.url}/bucky.nrrd`);
  await expect(page.locator(".task-card")).toContainText(/KB of 2\.10 MB/);
  await page.getByRole("button", { name: "Cancel" }).click();
  await expect(page.locator(".task-card")).toHaveCount(0);
  await expect(page.getByRole("heading", { name: "Volumes" })).toBeVisible();
  await expect(kept(page)).toHaveCount(0);
});

test("after a file of this device was read, the page reports that other hosts are blocked", async ({
  page,
}) => {
  copyFileSync(join(demoFolder, "bucky.isosplat"), join(folder, "bucky.isosplat"));
  await open(page, `${host.url}bucky.isosplat`);
  await complete(page);
  await page.waitForFunction(() => document.querySelector("link[href*=device_files]") !== null);
  await page.evaluate(() => {
    const transfer = new DataTransfer();
    transfer.items.add(new File(["dear"], "letter.txt"));
    document.body.dispatchEvent(
      new DragEvent("drop", { dataTransfer: transfer, bubbles: true, cancelable: true }),
    );
  });
  await expect(message(page)).toContainText("Expected a store (.isosplat) or a volume");
  await expect(message(page)).toContainText(
    "makes no requests to other sites: load the page again",
  );
});

test("a scale of an OME-Zarr image is chosen, built and kept; a link to it opens it", async ({
  page,
}) => {
  const zarr = join(folder, "ball.ome.zarr");
  const sizes = [40, 20];
  const axes = ["z", "y", "x"].map((name) => ({ name, type: "space", unit: "millimeter" }));
  const datasets = sizes.map((size, i) => ({
    path: String(i),
    coordinateTransformations: [{ type: "scale", scale: Array(3).fill(40 / size) }],
  }));
  writeGroup(zarr, 3, { ome: { version: "0.5", multiscales: [{ axes, datasets }] } });
  for (const [i, size] of sizes.entries()) {
    await writeArray(join(zarr, String(i)), {
      version: 3,
      shape: [size, size, size],
      chunks: [16, 16, 16],
      isBlosc: true,
      value: (index) =>
        Math.round(500 * Math.hypot(...index.map((at) => (2 * at - size + 1) / size))),
    });
  }
  const address = `${host.url}ball.ome.zarr`;
  let release = () => {};
  const released = new Promise<void>((resolve) => {
    release = resolve;
  });
  await page.route("**/0/c/**", async (route) => {
    await released;
    await route.continue();
  });
  await open(page, address);
  await expect(page.getByRole("button", { name: /20 × 20 × 20 voxels/ })).toBeVisible();
  await page.getByRole("button", { name: /40 × 40 × 40 voxels · 128 KB/ }).click();
  // The smaller scale is shown while the chosen one is being fetched. Settings that are made
  // meanwhile stay.
  await expect(page.locator(".volume-name")).toHaveText("ball");
  await expect(page.getByText("Preview: 20 × 20 × 20 of 40 × 40 × 40 voxels")).toBeVisible();
  await settled(page);
  await page.getByRole("application").press("]");
  await settled(page);
  const isovalue = new URL(page.url()).searchParams.get("isovalue");
  expect(isovalue).not.toBeNull();
  release();
  await expect(page.getByText("Preview: 20 × 20 × 20")).toHaveCount(0);
  await complete(page);
  await settled(page);
  expect(new URL(page.url()).searchParams.get("isovalue")).toBe(isovalue);
  await settled(page);
  await expect(page.locator(".volume-name")).toHaveText("ball");
  expect(new URL(page.url()).searchParams.get("src")).toBe(`${address}/0`);
  const before = (await host.accessLog()).length;
  await page.reload();
  await complete(page);
  const requests = (await host.accessLog()).slice(before);
  const chunks = requests.filter((line) => line.includes("/c/"));
  expect(chunks).toEqual([]);
  rmSync(join(zarr, "1", "zarr.json"));
  await open(page, address);
  await expect(message(page)).toContainText("ball.ome.zarr/1: expected zarr.json");
});
