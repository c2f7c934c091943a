/** The picture of the element in a page, and whether it is the expected one. */
import type { Browser } from "@playwright/test";
import { decodePng, type Pixels } from "../../browser/support/pixels.ts";

/** How long a page may take until its picture is complete. Development servers compile meanwhile. */
const limitMs = 120_000;

/**
 * The element's picture once it is complete, 400 × 300 pixels. Rejects with what the page has reported
 * if it is not, or if anything else went wrong in the page.
 */
export async function pictureOf(browser: Browser, url: string): Promise<Pixels> {
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
  try {
    await page.goto(url);
    await page
      .waitForFunction(
        () => document.querySelector("isosplat-viewer")?.progress?.complete,
        undefined,
        { timeout: limitMs },
      )
      .catch((error: Error) => found.push(error.message));
    if (found.length > 0) throw new Error(`${url}\n${found.join("\n")}`);
    const base64 = await page.evaluate(async () => {
      const view = document.querySelector("isosplat-viewer");
      if (!view) throw new Error("the element has been removed");
      const bytes = new Uint8Array(await (await view.screenshot()).arrayBuffer());
      return btoa(Array.from(bytes, (byte) => String.fromCharCode(byte)).join(""));
    });
    return await decodePng(page, Buffer.from(base64, "base64"));
  } finally {
    await page.close();
  }
}

/** The share of pixels that are not as the picture's corner. */
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
