/** Pictures as pixels, and comparison of two pictures. */

export interface Pixels {
  width: number;
  height: number;
  /** RGBA, 8 bits each, rows from the top. */
  rgba: Buffer;
}

interface Decoded {
  width: number;
  height: number;
  base64: string;
}

/** A page of Playwright or of Puppeteer. */
export interface EvaluatingPage {
  evaluate(decode: (encoded: string) => Promise<Decoded>, encoded: string): Promise<Decoded>;
}

/** Decodes a PNG in the browser. */
export async function decodePng(page: EvaluatingPage, png: Buffer): Promise<Pixels> {
  const { width, height, base64 } = await page.evaluate(async (encoded) => {
    const bytes = Uint8Array.from(atob(encoded), (c) => c.charCodeAt(0));
    const bitmap = await createImageBitmap(new Blob([bytes], { type: "image/png" }));
    const { width, height } = bitmap;
    const context = new OffscreenCanvas(width, height).getContext("2d");
    if (!context) throw new Error("no 2D context");
    context.drawImage(bitmap, 0, 0);
    const { data } = context.getImageData(0, 0, width, height);
    // The string is built in pieces, because the stack limits the number of arguments of a call.
    let binary = "";
    for (let at = 0; at < data.length; at += 8192) {
      binary += String.fromCharCode(...data.subarray(at, at + 8192));
    }
    return { width, height, base64: btoa(binary) };
  }, png.toString("base64"));
  return { width, height, rgba: Buffer.from(base64, "base64") };
}

export interface Comparison {
  /** Pixels of the second picture that are not background. */
  covered: number;
  /** Pixels that differ by more than 60, summed over R, G and B. */
  differing: number;
  /**
   * Covered pixels of the first picture that are more than 1 px from any covered pixel of the
   * second.
   */
  stray: number;
  /** The same with the pictures exchanged. */
  lost: number;
}

/**
 * A pixel is covered if it differs from the background by more than this, summed over R, G and B.
 */
const minCover = 12;
const maxDifference = 60;

/** Compares pictures of the same size on the same background (0xrrggbb). */
export function comparePixels(ours: Pixels, truth: Pixels, background: number): Comparison {
  const { width, height } = truth;
  if (ours.width !== width || ours.height !== height) {
    throw new Error(`sizes differ: ${ours.width}×${ours.height}, ${width}×${height}`);
  }
  const back = [background >> 16, (background >> 8) & 255, background & 255];
  const isCovered = ({ rgba }: Pixels, i: number): boolean =>
    back.reduce((sum, value, c) => sum + Math.abs((rgba[4 * i + c] ?? 0) - value), 0) > minCover;
  const isNearCovered = (pixels: Pixels, i: number): boolean => {
    const x = i % width;
    const y = Math.floor(i / width);
    for (let v = Math.max(0, y - 1); v <= Math.min(height - 1, y + 1); ++v) {
      for (let u = Math.max(0, x - 1); u <= Math.min(width - 1, x + 1); ++u) {
        if (isCovered(pixels, v * width + u)) return true;
      }
    }
    return false;
  };
  const result: Comparison = { covered: 0, differing: 0, stray: 0, lost: 0 };
  for (let i = 0; i < width * height; ++i) {
    let difference = 0;
    for (let c = 4 * i; c < 4 * i + 3; ++c) {
      difference += Math.abs((ours.rgba[c] ?? 0) - (truth.rgba[c] ?? 0));
    }
    const isCoveredThere = isCovered(truth, i);
    if (isCoveredThere) ++result.covered;
    if (difference > maxDifference) ++result.differing;
    if (isCovered(ours, i) && !isNearCovered(truth, i)) ++result.stray;
    if (isCoveredThere && !isNearCovered(ours, i)) ++result.lost;
  }
  return result;
}
