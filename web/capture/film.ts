import type { Camera, PictureSize } from "../viewer/types.ts";
import type { Viewer } from "../viewer/viewer.ts";
import type { FrameView } from "./frame_paths.ts";
import { drawMarks } from "./marked_pixels.ts";
import { type CaptureProgress, capturePixels } from "./picture.ts";

/** The destination of a film's frames. */
export interface FilmFile {
  /** rgba: rows from the top. */
  add(rgba: Uint8ClampedArray<ArrayBuffer>): Promise<void>;
  finish(): Promise<Blob>;
  /** Frees its resources; call it after finish() as well. */
  close(): void;
}

export interface FilmOptions {
  /** The marks above a frame (marksSvg); empty: none. */
  marks?: (camera: Camera) => string;
  signal: AbortSignal;
  progress(progress: CaptureProgress): void;
}

/**
 * Draws each frame once its data have arrived, however long this takes, and adds it to the file.
 * The viewer's view is restored; playing ends. Rejects with a RendererError, the file's error, or the signal's
 * reason.
 */
export async function captureFilm(
  viewer: Viewer,
  size: PictureSize,
  frames: readonly FrameView[],
  file: FilmFile,
  { signal, progress, marks }: FilmOptions,
): Promise<Blob> {
  const { surfaces, time } = viewer;
  time?.pause();
  const step = time?.step;
  let shown = surfaces;
  let pixels: Uint8ClampedArray<ArrayBuffer> | undefined;
  try {
    for (const [i, frame] of frames.entries()) {
      progress({ share: i / frames.length });
      if (frame.surfaces !== shown) viewer.setSurfaces(frame.surfaces);
      shown = frame.surfaces;
      if (frame.step !== undefined) await time?.setStep(frame.step);
      if (!pixels || !isSameView(frame, frames[i - 1])) {
        pixels = await capturePixels(viewer, { ...size, camera: frame.camera }, signal);
        const drawn = marks?.(frame.camera) ?? "";
        if (drawn) await drawMarks(pixels, size, 0, drawn);
      }
      // The file may take ownership of the pixels.
      await file.add(isSameView(frame, frames[i + 1]) ? pixels.slice() : pixels);
    }
    return await file.finish();
  } finally {
    file.close();
    if (step !== undefined) void time?.setStep(step);
    if (shown !== surfaces) viewer.setSurfaces(surfaces);
    viewer.preparePicture(null);
  }
}

function isSameView(a: FrameView, b: FrameView | undefined): boolean {
  return a.camera === b?.camera && a.surfaces === b.surfaces && a.step === b.step;
}
