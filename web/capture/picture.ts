import type { Progress } from "../stream/types.ts";
import type { PictureInParts, PictureSize, PictureView } from "../viewer/types.ts";
import type { Viewer } from "../viewer/viewer.ts";
import { drawMarks } from "./marked_pixels.ts";
import { PngStream } from "./png_stream.ts";

/** Longest width and height of a picture, in pixels: kMaxImageSize of shared/render/frame/image_tile.h. */
export const mostPixels = 16384;
/** Size of the parts that are drawn separately: a part takes about 0.1 GB of GPU memory. */
const partWidth = 1024;
const partHeight = 1024;

export interface CaptureProgress {
  /** Fraction of the picture that is drawn, 0 … 1; undefined while data arrive. */
  share?: number;
  bytesToGo?: number;
}

export interface CaptureOptions {
  /** Without the background. */
  transparent?: boolean;
  /** The marks above the picture (marksSvg), once its data have arrived; empty: none. */
  marks?: () => string;
  signal: AbortSignal;
  progress(progress: CaptureProgress): void;
}

/**
 * The viewer's present view as a PNG of this size. Its data are fetched first, as far as the sample
 * budget allows. Memory: one row of parts. Rejects with a RendererError, or the signal's reason.
 */
export async function capturePng(
  viewer: Viewer,
  { width, height }: PictureSize,
  { transparent = false, marks, signal, progress }: CaptureOptions,
): Promise<Blob> {
  viewer.preparePicture({ width, height });
  try {
    await whenComplete(viewer, signal, progress);
    const picture = viewer.beginPicture({ transparent });
    try {
      const png = new PngStream(width, height, transparent);
      const drawn = marks?.() ?? "";
      for (let top = 0; top < height; top += partHeight) {
        const rows = Math.min(partHeight, height - top);
        const left = (share: number) => progress({ share: (top + share * rows) / height });
        const pixels = await drawRows(picture, top, rows, signal, left);
        if (drawn) await drawMarks(pixels, { width, height: rows }, top, drawn);
        await png.addRows(pixels);
      }
      return await png.finish();
    } finally {
      picture.end();
    }
  } finally {
    viewer.preparePicture(null);
  }
}

/** Draws rows of the picture, over its whole width. */
async function drawRows(
  picture: PictureInParts,
  top: number,
  rows: number,
  signal: AbortSignal,
  progress: (share: number) => void,
): Promise<Uint8ClampedArray<ArrayBuffer>> {
  const { width } = picture;
  const all = new Uint8ClampedArray(4 * width * rows);
  for (let left = 0; left < width; left += partWidth) {
    progress(left / width);
    await nextFrame();
    signal.throwIfAborted();
    const columns = Math.min(partWidth, width - left);
    const part = picture.draw(left, top, columns, rows);
    for (let y = 0; y < rows; ++y) {
      const row = part.subarray(4 * y * columns, 4 * (y + 1) * columns);
      all.set(row, 4 * (y * width + left));
    }
  }
  return all;
}

/** Pictures in the mean of a film's frame: half as many as in a still picture, which is seen longer. */
const filmPictures = 4;

/** All pixels of a frame of a film, once its data have arrived: RGBA, rows from the top. */
export async function capturePixels(
  viewer: Viewer,
  view: PictureView,
  signal: AbortSignal,
): Promise<Uint8ClampedArray<ArrayBuffer>> {
  viewer.preparePicture(view);
  await whenComplete(viewer, signal, () => {});
  const picture = viewer.beginPicture({ pictures: filmPictures });
  try {
    return await drawRows(picture, 0, view.height, signal, () => {});
  } finally {
    picture.end();
  }
}

/** Resolves when everything that the view needs is resident, within the sample budget. */
export async function whenComplete(
  viewer: Viewer,
  signal: AbortSignal,
  progress: (progress: CaptureProgress) => void,
): Promise<void> {
  signal.throwIfAborted();
  if (!viewer.isBusy) return;
  await new Promise<void>((resolve, reject) => {
    const removers = [
      viewer.on("progress", ({ bytesToGo }: Progress) => progress({ bytesToGo })),
      viewer.on("busy", (isBusy) => {
        if (!isBusy) end(resolve);
      }),
      viewer.on("error", (error) => {
        if (viewer.info === null) end(() => reject(error));
      }),
    ];
    const abort = (): void => end(() => reject(signal.reason));
    signal.addEventListener("abort", abort);
    const end = (settle: () => void): void => {
      for (const remove of removers) remove();
      signal.removeEventListener("abort", abort);
      settle();
    };
  });
}

/** Lets the browser show changes and handle clicks. */
function nextFrame(): Promise<void> {
  return new Promise((resolve) => {
    requestAnimationFrame(() => setTimeout(resolve));
  });
}
