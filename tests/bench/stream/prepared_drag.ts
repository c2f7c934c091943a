/** A drag over all isovalues, ten seconds after the first complete picture. */
import type { Browser, Page } from "@playwright/test";
import { trueCases } from "../../browser/support/truth.ts";
import type { Bench } from "../harness/benchmark.ts";
import { type Link, Visitor } from "./visit.ts";

/** Time for coarse levels of other isovalues to arrive, and duration of the drag (ms). */
const preparation = 10_000;
const duration = 5000;
/** Vertical field of view of the page's camera, in degrees. */
const fieldOfView = 30;

export interface PreparedDrag {
  name: string;
  isovalue: number;
  /** Largest cell to be drawn, in px. */
  reach: number;
}

/** Size of a cell of level 0 at the camera's target, in px. */
async function pixelsPerCell(page: Page, url: string, name: string, distance: number) {
  const response = await page.request.get(`${url}v1/volumes/${name}`);
  const { spacing } = (await response.json()) as { spacing: number[] };
  const height = await page.evaluate(() => document.querySelector("canvas")?.height ?? 0);
  const halfImage = distance * Math.tan(((fieldOfView / 2) * Math.PI) / 180);
  return (Math.max(...spacing) * height) / (2 * halfImage);
}

/** Drags the isovalue over its whole range. Returns the coarsest level that the page has shown. */
async function coarsestLevel(page: Page): Promise<number> {
  return page.evaluate(async (duration) => {
    const slider = document.querySelector<HTMLInputElement>(".isovalue-slider");
    const status = document.querySelector(".status-level");
    if (!slider || !status) throw new Error("the page has no isovalue slider, or no status");
    let coarsest = 0;
    const begin = performance.now();
    for (let t = 0; t < 1; t = (performance.now() - begin) / duration) {
      slider.valueAsNumber = Number(slider.min) + t * (Number(slider.max) - Number(slider.min));
      slider.dispatchEvent(new Event("input", { bubbles: true }));
      await new Promise((resolve) => requestAnimationFrame(resolve));
      // The status lags behind by 0.2 s, so at first it shows the view at rest.
      if (performance.now() - begin < 400) continue;
      coarsest = Math.max(coarsest, Number(/\d+$/.exec(status.textContent ?? "")?.[0] ?? 0));
    }
    return coarsest;
  }, duration);
}

export async function dragPrepared(
  bench: Bench,
  browser: Browser,
  url: string,
  { name, isovalue, reach }: PreparedDrag,
  link?: Link,
): Promise<void> {
  const view = trueCases.find((each) => each.name === name)?.views.far;
  if (!view) throw new Error(`no camera for ${name}`);
  const visitor = await Visitor.arrive(browser, link);
  const { page } = visitor;
  const what = `${name}, dragged over the range in 5 s, 10 s after the first complete picture`;
  try {
    await page.goto(`${url}?volume=${name}&isovalue=${isovalue}&camera=${view}`);
    await visitor.mark("isosplat:complete");
    await page.waitForTimeout(preparation);
    const before = visitor.data.requests;
    const level = await coarsestLevel(page);
    const distance = Number(view.split(",")[2]);
    const cell = 2 ** level * (await pixelsPerCell(page, url, name, distance));
    bench.report(what, "largest cell", "px", cell, { atMost: reach });
    bench.report(what, "requests", "", visitor.data.requests - before, { atMost: 0 });
    bench.report(what, "over the wire until then", "MB", visitor.data.bytes / 1e6);
  } finally {
    await visitor.leave();
  }
}
