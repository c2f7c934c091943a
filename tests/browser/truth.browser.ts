/**
 * Complete means complete: whatever was looked at before, the page's picture equals the native
 * renderer's of every sample of level 0, in all but 0.01 % of the covered pixels, and shows nothing
 * where there is nothing. `npm run bench -- truth` does the same for more volumes.
 */
import { execFileSync } from "node:child_process";
import { existsSync, mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { expect, type Page, test } from "@playwright/test";
import { volumesFolder } from "../bench/harness/volumes.ts";
import { program, type RunningServer, serve } from "./support/server.ts";
import {
  completeAndSettled,
  differenceFrom,
  mostDiffering,
  nativePicture,
  pageSize,
  queryOf,
  type TrueCase,
  trueCases,
} from "./support/truth.ts";

const cases = trueCases.filter(({ name }) => ["aneurysm", "engine", "CT_AVM"].includes(name));
const canvas = { width: 608, height: 472 };

test.skip(!existsSync(volumesFolder), `no real volumes in ${volumesFolder}`);
test.use({ viewport: pageSize(canvas) });

let folder: string;
let server: RunningServer;
const truths = new Map<string, Buffer>();

const storeOf = ({ name }: TrueCase): string => join(folder, `${name}.isosplat`);

test.beforeAll(async () => {
  test.setTimeout(300_000);
  folder = mkdtempSync(join(tmpdir(), "isosplat-truth-"));
  for (const each of cases) {
    const volume = join(volumesFolder, each.file);
    execFileSync(program, ["build", volume, "-o", storeOf(each)], { stdio: "pipe" });
    for (const camera of [each.far, each.near]) {
      const output = join(folder, "truth.png");
      truths.set(
        `${each.name} ${camera}`,
        nativePicture(storeOf(each), each, camera, canvas, output),
      );
    }
  }
  server = await serve([folder]);
});
test.afterAll(async () => {
  await server?.stop();
  if (folder) rmSync(folder, { recursive: true });
});

async function expectTruth(page: Page, { name }: TrueCase, camera: string): Promise<void> {
  await completeAndSettled(page);
  const truth = truths.get(`${name} ${camera}`);
  if (!truth) throw new Error(`no picture of ${name} from ${camera}`);
  const { covered, differing, stray } = await differenceFrom(page, truth);
  expect(covered).toBeGreaterThan(5000);
  expect(differing).toBeLessThanOrEqual(mostDiffering * covered);
  expect(stray).toBe(0);
}

/** To the right by so many steps and back to the very same view. */
async function dragAndBack(page: Page, steps: number): Promise<void> {
  const at = (step: number): Promise<void> => page.mouse.move(250 + 6 * step, 220 + 2 * step);
  await at(0);
  await page.mouse.down();
  for (let step = 1; step <= steps; ++step) await at(step);
  for (let step = steps - 1; step >= 0; --step) await at(step);
  await page.mouse.up();
}

async function setIsovalue(page: Page, isovalue: number): Promise<void> {
  await page.evaluate((isovalue) => {
    const slider = document.querySelector<HTMLElement & { value: number }>(
      "wa-slider.isovalue-slider",
    );
    if (!slider) throw new Error("no slider");
    slider.value = isovalue;
    slider.dispatchEvent(new Event("input", { bubbles: true }));
  }, isovalue);
}

for (const each of cases) {
  for (const view of ["far", "near"] as const) {
    test(`${each.name}, ${view}: a complete picture is the true one`, async ({ page }) => {
      test.setTimeout(240_000);
      await page.goto(server.url + queryOf(each, each[view]));
      await expectTruth(page, each, each[view]);
      await expect(page.locator(".status-level")).toHaveText("full resolution");
    });
  }
}

test("whatever was looked at before", async ({ page }) => {
  test.setTimeout(300_000);
  const [each] = cases;
  if (!each) throw new Error("no volume");
  await page.goto(server.url + queryOf(each, each.far));
  await completeAndSettled(page);
  await dragAndBack(page, 12);
  await expectTruth(page, each, each.far);

  // Another isovalue, left before it is complete.
  await setIsovalue(page, 60.5);
  await setIsovalue(page, each.isovalue);
  await expectTruth(page, each, each.far);

  await setIsovalue(page, 40.5);
  await completeAndSettled(page);
  await setIsovalue(page, each.isovalue);
  await expectTruth(page, each, each.far);
});
