import type { PictureSize } from "../viewer/types.ts";
import type { Viewer } from "../viewer/viewer.ts";
import type { FrameView } from "./frame_paths.ts";
import { type CaptureProgress, capturePixels } from "./picture.ts";

/** The destination of a film's frames. */
export interface FilmFile {
  /** rgba: rows from the top. */
  add(rgba: Uint8ClampedArray<ArrayBuffer>): Promise<void>;
  finish(): Promise<Blob>;
  /** Frees its resources; call it after finish() as well. */
  close(): void;
}

/**
 * Draws each frame once its data have arrived, however long this takes, and adds it to the file.
 * The viewer's view is restored. Rejects with a RendererError, the file's error, or the signal's
 * reason.
 */
export async function captureFilm(
  viewer: Viewer,
  size: PictureSize,
  frames: readonly FrameView[],
  file: FilmFile,
  { signal, progress }: { signal: AbortSignal; progress(progress: CaptureProgress): void },
): Promise<Blob> {
  const { surfaces } = viewer;
  let shown = surfaces;
  try {
    for (const [i, frame] of frames.entries()) {
      progress({ share: i / frames.length });
      if (frame.surfaces !== shown) viewer.setSurfaces(frame.surfaces);
      shown = frame.surfaces;
      await file.add(await capturePixels(viewer, { ...size, camera: frame.camera }, signal));
    }
    return await file.finish();
  } finally {
    file.close();
    if (shown !== surfaces) viewer.setSurfaces(surfaces);
    viewer.preparePicture(null);
  }
}
