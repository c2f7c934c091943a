/**
 * Occluded regions are not fetched: compares the page's picture at rest with the native renderer's
 * picture of all chunks at full resolution.
 */
import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { expect, type Page, test } from "@playwright/test";
import { chunksOf } from "./support/chunks.ts";
import { saveData, slideTo } from "./support/in_page.ts";
import { demoFolder, program, type RunningServer, serve } from "./support/server.ts";
import { compare, complete, savedPicture, settled } from "./support/view.ts";

test.use({ viewport: { width: 800, height: 520 } });
// A store that was read as a whole needs no occlusion queries.
test.beforeEach(({ page }) => page.addInitScript(saveData));

const volume = "mandelbulb";
const isovalue = 226.5;
const camera = "40,25,600,127.5,127.5,127.5";
/**
 * Share of all pixels that may differ. They are at edges of coarse chunks that cover too few pixels
 * to be worth a request.
 */
const maxDiffering = 0.002;

let server: RunningServer;
let folder: string;

test.beforeAll(async () => {
  folder = mkdtempSync(join(tmpdir(), "isosplat-occlusion-"));
  server = await serve([join(demoFolder, `${volume}.isosplat`)]);
});
test.afterAll(async () => {
  await server.stop();
  rmSync(folder, { recursive: true });
});

const address = (isovalue: number): string =>
  `${server.url}?volume=${volume}&isovalue=${isovalue}&camera=${camera}&kind=ellipse&background=ffffff`;

/** Compares a picture with the picture of all chunks of level 0. */
async function expectEverything(page: Page, picture: Buffer): Promise<void> {
  const { width, height } = await compare(page, picture, picture);
  const out = join(folder, "everything.png");
  execFileSync(program, [
    ...["render", join(demoFolder, `${volume}.isosplat`), "--isovalue", String(isovalue)],
    ...["-o", out, "--size", `${width}x${height}`, "--camera", camera, "--kind", "ellipse"],
    ...["--background", "ffffff", "--colour", "d9ccb3", "--level", "0"],
  ]);
  const difference = await compare(page, picture, readFileSync(out));
  expect(difference.covered).toBeGreaterThan(0.1);
  expect(difference.differing).toBeLessThan(maxDiffering);
}

/** Number of chunks of level 0 for the isovalue. */
async function allChunks(page: Page): Promise<number> {
  const answer = await page.request.get(`${server.url}v1/volumes/${volume}`);
  const { urls } = (await answer.json()) as { urls: { chunks: string } };
  const address = `${server.url}${urls.chunks.slice(1)}?isovalue=${isovalue}&level=0`;
  const head = await page.request.head(address);
  return Number(head.headers()["x-isosplat-chunks"]);
}

test("the picture equals the one of all chunks", { tag: "@slow" }, async ({ page }) => {
  test.setTimeout(120_000);
  const urls: string[] = [];
  page.on("request", (request) => urls.push(request.url()));
  await page.goto(address(isovalue));
  await complete(page, 60_000);
  await settled(page);
  const ours = await savedPicture(page);
  const fetched = chunksOf(urls).filter((chunk) => chunk.startsWith("0/")).length;
  // Without fetched chunks, the comparison would be meaningless.
  expect(fetched).toBeGreaterThan(0);
  expect(fetched).toBeLessThan(0.9 * (await allChunks(page)));

  await expectEverything(page, ours);
});

test("the picture does not depend on earlier views", { tag: "@slow" }, async ({ page }) => {
  test.setTimeout(180_000);
  await page.goto(address(100.5));
  await complete(page, 60_000);
  await page.evaluate(slideTo, isovalue);
  await settled(page, 60_000);
  await complete(page);
  await expectEverything(page, await savedPicture(page));
});
