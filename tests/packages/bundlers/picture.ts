/** The picture of the element in a page, and whether it is the expected one. */
import { type Browser, chromium } from "@playwright/test";
import { launchOptions } from "../../browser/support/chromium.ts";
import { decodePng, type Pixels } from "../../browser/support/pixels.ts";

/** How long a page may take until its picture is complete. Development servers compile meanwhile. */
const limitMs = 120_000;

/**
 * The element's picture once it is complete, 400 × 300 pixels, in a browser of its own. Rejects with what
 * the page has reported if it is not, or if anything else went wrong in the page.
 */
export async function pictureOf(url: string): Promise<Pixels> {
  const browser = await chromium.launch(launchOptions);
  try {
    return await pictureIn(browser, url);
  } finally {
    await browser.close();
  }
}

async function pictureIn(browser: Browser, url: string): Promise<Pixels> {
  const page = await browser.newPage({ viewport: { width: 600, height: 500 } });
  const found: string[] = [];
  page.on("pageerror", (error) => found.push(error.message));
  page.on("console", (message) => {
    const isIcon = message.location().url.endsWith("/favicon.ico");
    if (message.type() === "error" && !isIcon) found.push(message.text());
  });
  await page.exposeFunction("reportFault", (text: string) => found.push(`fault: ${text}`));
  // tsx would add helpers to functions with names.
  await page.addInitScript(() =>
    addEventListener(
      "fault",
      (event) => {
        const { reportFault } = window as never as { reportFault(text: string): void };
        reportFault((event as CustomEvent<Error>).detail.message);
      },
      true,
    ),
  );
  await page.goto(url);
  const end = performance.now() + limitMs;
  let picture = "";
  while (!picture && found.length === 0) {
    if (performance.now() > end) found.push(`no complete picture after ${limitMs / 1000} s`);
    await page.waitForTimeout(100);
    picture = await page.evaluate(completePicture).catch((error: Error) => {
      // Development servers load a page again when they have found what it imports.
      if (!error.message.includes("context was destroyed")) found.push(error.message);
      return "";
    });
  }
  if (found.length > 0) throw new Error(`${url}\n${found.join("\n")}`);
  return decodePng(page, Buffer.from(picture, "base64"));
}

/** In the page: the element's picture in Base64; empty while it is not complete. */
async function completePicture(): Promise<string> {
  const view = document.querySelector("isosplat-viewer");
  if (!view?.progress?.complete) return "";
  const bytes = new Uint8Array(await (await view.screenshot()).arrayBuffer());
  return btoa(Array.from(bytes, (byte) => String.fromCharCode(byte)).join(""));
}

/** The fraction of pixels that differ from the corner of the picture. */
export function coverage({ width, height, rgba }: Pixels): number {
  let count = 0;
  for (let at = 0; at < rgba.length; at += 4) {
    if ([0, 1, 2].some((c) => Math.abs((rgba[at + c] ?? 0) - (rgba[c] ?? 0)) > 12)) ++count;
  }
  return count / (width * height);
}

/** The share of pixels of which a channel differs by more than 12 of 255. */
export function difference(a: Pixels, b: Pixels): number {
  if (a.width !== b.width || a.height !== b.height) return 1;
  let count = 0;
  for (let at = 0; at < a.rgba.length; at += 4) {
    if ([0, 1, 2].some((c) => Math.abs((a.rgba[at + c] ?? 0) - (b.rgba[at + c] ?? 0)) > 12))
      ++count;
  }
  return count / (a.width * a.height);
}
