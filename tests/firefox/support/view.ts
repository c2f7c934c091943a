/** Helpers with which tests query the page in Firefox, and wait for it. */
import { readdirSync, readFileSync, rmSync, watch } from "node:fs";
import { join } from "node:path";
import type { Page } from "puppeteer-core";
import { completeText } from "../../support/complete_text.ts";
import type { Firefox } from "./firefox.ts";

const timeout = 30_000;

/** Waits until the text of the first element that the selector finds matches the pattern. */
export async function shows(page: Page, selector: string, pattern: RegExp): Promise<void> {
  const textOf = (sought: string) => document.querySelector(sought)?.textContent?.trim();
  try {
    await page.waitForFunction(
      (sought, source, flags) => {
        const text = document.querySelector(sought)?.textContent?.trim();
        return text !== undefined && new RegExp(source, flags).test(text);
      },
      { timeout },
      selector,
      pattern.source,
      pattern.flags,
    );
  } catch (error) {
    const found = await page.evaluate(textOf, selector);
    throw new Error(`expected ${pattern} in ${selector}, found "${found}"`, { cause: error });
  }
}

/** Waits until nothing is left to fetch for the view, and nothing is missing. */
export function complete(page: Page): Promise<void> {
  return shows(page, ".status-state", completeText);
}

/** Waits until neither the picture nor the address will change without an action. */
export async function settled(page: Page): Promise<void> {
  await page.waitForSelector("[role=application][aria-busy=false]", { timeout });
}

/** Waits until nothing covers the picture, and there is no message beside it. */
export async function saysNothing(page: Page): Promise<void> {
  await page.waitForFunction(() => !document.querySelector("[role=alert], .banner, wa-spinner"), {
    timeout,
  });
}

/** A parameter of the page's address, when the view rests. */
export async function parameter(page: Page, name: string): Promise<string | null> {
  await settled(page);
  const address = await page.evaluate(() => location.href);
  return new URL(address).searchParams.get(name);
}

/** Azimuth, elevation, distance and target, when the view rests. */
export async function camera(page: Page): Promise<number[]> {
  return ((await parameter(page, "camera")) ?? "").split(",").map(Number);
}

/** The picture that "Save a picture" saves: a PNG. */
export async function savedPicture({ downloads }: Firefox, page: Page): Promise<Buffer> {
  const saved = new Promise<Buffer>((resolve, reject) => {
    const late = setTimeout(() => {
      watcher.close();
      reject(new Error(`no picture was saved; found ${readdirSync(downloads).join(", ")}`));
    }, timeout);
    const watcher = watch(downloads, () => {
      const name = readdirSync(downloads).find((file) => file.endsWith(".png"));
      if (!name) return;
      const file = join(downloads, name);
      const png = readFileSync(file);
      // An incomplete file lacks the last chunk of a PNG, IEND.
      if (png.subarray(-8, -4).toString("latin1") !== "IEND") return;
      clearTimeout(late);
      watcher.close();
      rmSync(file);
      resolve(png);
    });
  });
  await page.locator("wa-button[title='Save a picture']").click();
  return saved;
}
