/** The page in its main states, on a desktop and on a phone: docs/pictures/page_*.jpg. */
import { mkdirSync } from "node:fs";
import { join } from "node:path";
import type { Browser, Page } from "@playwright/test";
import { serve } from "../../browser/support/server.ts";
import { openSection, settled } from "../../browser/support/view.ts";
import type { Bench } from "../harness/benchmark.ts";
import { root } from "../harness/paths.ts";
import { launch } from "../stream/visit.ts";

const stores: [name: string, file: string][] = [
  ["engine", "engine.nhdr"],
  ["lobster", "lobster.nhdr"],
  ["aneurysm", "aneurysm.nhdr"],
  ["head", "chris_t1.nii.gz"],
];

interface State {
  name: string;
  /** The query of the URL. If it is empty, the page is the start page. */
  view: string;
  act?(page: Page): Promise<void>;
}

const section = (name: string) => async (page: Page) => {
  const more = page.getByRole("button", { name: "More controls" });
  if (await more.isVisible()) await more.click();
  await openSection(page, name);
  await page.locator(`wa-details[summary="${name}"]`).evaluate((e) => e.scrollIntoView());
};

const states: State[] = [
  { name: "start", view: "" },
  { name: "volume", view: "volume=head" },
  {
    name: "surfaces",
    view: "volume=engine&isovalue=60.5,180.5&opacity=0.35,1&show=axes,scale,box",
  },
  {
    name: "clipping",
    view: "volume=engine&isovalue=60.5&clip=0,0.5,0,1,0,1",
    act: section("Clipping"),
  },
  {
    name: "slices",
    view: "volume=head&isovalue=70.5&clip=0,1,0,0.5,0,1&slices=,0.5,",
    act: section("Slices"),
  },
  {
    name: "measure",
    view: "volume=lobster",
    async act(page) {
      await section("Measure")(page);
      const tools = page.getByRole("group", { name: "Measure", exact: true });
      await tools.getByRole("button", { name: "Distance" }).click();
      const fewer = page.getByRole("button", { name: "Fewer controls" });
      if (await fewer.isVisible()) await fewer.click();
      const box = await page.getByRole("application").boundingBox();
      if (!box) throw new Error("expected a picture, found none");
      for (const share of [0.43, 0.49]) {
        await page.mouse.click(box.x + share * box.width, box.y + 0.5 * box.height);
      }
    },
  },
  { name: "light", view: "volume=aneurysm&isovalue=100.5", act: section("Light") },
  {
    name: "pictures",
    view: "volume=head",
    async act(page) {
      await page.getByRole("application").press("Shift+S");
      await page.getByRole("dialog", { name: "Pictures and films" }).waitFor();
    },
  },
];

const devices = [
  {
    name: "desktop",
    options: { viewport: { width: 1280, height: 800 }, colorScheme: "light" },
  },
  {
    name: "phone",
    options: {
      viewport: { width: 390, height: 780 },
      colorScheme: "dark",
      hasTouch: true,
      isMobile: true,
      deviceScaleFactor: 2,
    },
  },
] as const;

/** How long a picture may take on a busy machine (ms). */
const longestWait = 120_000;

/** Waits for the pictures of suggested isovalues, which are drawn while they are in view. */
async function choicesDrawn(page: Page): Promise<void> {
  await page.waitForFunction(() => {
    const pictures = [...document.querySelectorAll(".choice-picture")];
    const { top = 0, bottom = 0 } = pictures[0]?.getBoundingClientRect() ?? {};
    const areInView = pictures[0]?.checkVisibility() && top < innerHeight && bottom > 0;
    return !areInView || pictures.every(({ childElementCount }) => childElementCount > 0);
  });
}

async function draw(browser: Browser, url: string, state: State, file: string): Promise<void> {
  for (const { name, options } of devices) {
    const context = await browser.newContext({ ...options, reducedMotion: "reduce" });
    try {
      const page = await context.newPage();
      page.setDefaultTimeout(longestWait);
      await page.goto(state.view ? `${url}?${state.view}` : url, { waitUntil: "load" });
      if (state.view) await settled(page, longestWait);
      else await page.waitForFunction(() => [...document.images].every(({ complete }) => complete));
      await state.act?.(page);
      if (state.view) {
        await settled(page, longestWait);
        await choicesDrawn(page);
      }
      await page.screenshot({
        path: `${file}_${name}.jpg`,
        type: "jpeg",
        quality: 80,
        scale: "css",
      });
    } finally {
      await context.close();
    }
  }
}

/** Draws the states whose names match. */
export async function drawPageStates(bench: Bench, wanted: RegExp): Promise<void> {
  const drawn = states.filter(({ name }) => wanted.test(`page_${name}`));
  if (drawn.length === 0) return;
  const folder = join(bench.folder, "stores");
  mkdirSync(folder);
  for (const [name, file] of stores) {
    const volume = bench.volume(file);
    if (!volume) return;
    await bench.command(bench.isosplat, ["build", volume, "-o", join(folder, `${name}.isosplat`)]);
  }
  const server = await serve([folder]);
  const browser = await launch();
  try {
    for (const state of drawn) {
      bench.say(`page, ${state.name}`);
      await draw(browser, server.url, state, join(root, `docs/pictures/page_${state.name}`));
    }
  } finally {
    await browser.close();
    await server.stop();
  }
}
