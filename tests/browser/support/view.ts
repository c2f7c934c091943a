import { readFileSync } from "node:fs";
import { expect, type Page } from "@playwright/test";
import { completeText } from "../../support/complete_text.ts";

/**
 * Waits until the page reports that nothing is left to fetch for its view, and nothing is missing.
 */
export async function complete(page: Page, timeout = 30_000): Promise<void> {
  await expect(page.locator(".status-state")).toHaveText(completeText, { timeout });
}

/**
 * Waits until the page reports that neither the picture nor the address will change without an
 * action. The report is withdrawn by the same event that changes something.
 */
export async function settled(page: Page, timeout = 30_000): Promise<void> {
  await expect(page.getByRole("application")).toHaveAttribute("aria-busy", "false", { timeout });
}

/** Opens a section of the panel. While it opens, its contents move, and a click could miss them. */
export async function openSection(page: Page, name: string): Promise<void> {
  const opening = await page.locator(`wa-details[summary="${name}"]`).evaluateHandle((section) => ({
    isOpen: new Promise((resolve) => section.addEventListener("wa-after-show", resolve)),
  }));
  await page.getByRole("button", { name, exact: true }).click();
  await opening.evaluate(async ({ isOpen }) => {
    await isOpen;
  });
}

/** The picture that "Save a picture" saves: a PNG. */
export async function savedPicture(page: Page): Promise<Buffer> {
  const [download] = await Promise.all([
    page.waitForEvent("download"),
    page.getByRole("button", { name: "Save a picture" }).click(),
  ]);
  return readFileSync(await download.path());
}

export interface PictureDifference {
  width: number;
  height: number;
  /** Share of the pixels where any channel differs by more than 3 of 255. */
  differing: number;
  /** Share of the second picture's pixels that differ from its corner's colour. */
  covered: number;
}

/** Compares two PNGs of the same size; the browser decodes them. */
export function compare(page: Page, a: Buffer, b: Buffer): Promise<PictureDifference> {
  return page.evaluate(
    async (pictures) => {
      const [first, second] = await Promise.all(
        pictures.map(async (base64) => {
          const bytes = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
          const bitmap = await createImageBitmap(new Blob([bytes], { type: "image/png" }));
          const canvas = new OffscreenCanvas(bitmap.width, bitmap.height);
          const context = canvas.getContext("2d");
          context?.drawImage(bitmap, 0, 0);
          const data = context?.getImageData(0, 0, bitmap.width, bitmap.height);
          if (!data) throw new Error("no 2D context");
          return data;
        }),
      );
      if (!first || !second) throw new Error("two pictures are needed");
      if (first.width !== second.width || first.height !== second.height) {
        throw new Error(
          `sizes differ: ${first.width}×${first.height}, ${second.width}×${second.height}`,
        );
      }
      let differing = 0;
      let covered = 0;
      for (let i = 0; i < first.data.length; i += 4) {
        let most = 0;
        let fromCorner = 0;
        for (let c = 0; c < 3; ++c) {
          const value = second.data[i + c] ?? 0;
          most = Math.max(most, Math.abs((first.data[i + c] ?? 0) - value));
          fromCorner = Math.max(fromCorner, Math.abs((second.data[c] ?? 0) - value));
        }
        if (most > 3) ++differing;
        if (fromCorner > 3) ++covered;
      }
      const pixels = first.width * first.height;
      const { width, height } = first;
      return { width, height, differing: differing / pixels, covered: covered / pixels };
    },
    [a.toString("base64"), b.toString("base64")],
  );
}
