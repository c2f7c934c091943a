import type { PictureSize } from "../../viewer/types.ts";
import { Viewer } from "../../viewer/viewer.ts";
import type { ViewerOptions } from "../../viewer/viewer_events.ts";

/**
 * Runs `work` with a viewer on a canvas that is not visible, of this size in CSS pixels. Frees the viewer,
 * with its workers and its WebGL context, before the promise settles.
 */
export async function withHiddenViewer<T>(
  { width, height }: PictureSize,
  options: ViewerOptions,
  work: (viewer: Viewer) => Promise<T>,
): Promise<T> {
  const canvas = document.createElement("canvas");
  canvas.className = "hidden-view";
  canvas.ariaHidden = "true";
  // A canvas gets its size only by layout.
  canvas.style.width = `${width}px`;
  canvas.style.height = `${height}px`;
  document.body.append(canvas);
  const viewer = new Viewer(canvas, { ...options, controls: false });
  try {
    return await work(viewer);
  } finally {
    viewer.dispose();
    canvas.remove();
  }
}

/** Limits of time (ms) for `whenDrawn`. */
export interface DrawingLimits {
  /** Until something of a surface is drawn. */
  firstSurface: number;
  /** After that, until the picture is complete. */
  refining: number;
}

/**
 * Begins to wait until a viewer has drawn its surfaces completely, or as far as `limits` allow. `drawn` resolves
 * to whether there is a picture. `stop`: ends the wait; without a picture, `drawn` then resolves to false.
 */
export function whenDrawn(
  viewer: Viewer,
  limits: DrawingLimits,
): { drawn: Promise<boolean>; stop(): void } {
  let stop = () => {};
  const drawn = new Promise<boolean>((resolve) => {
    let isDrawn = false;
    let timer = setTimeout(() => end(), limits.firstSurface);
    const end = () => {
      clearTimeout(timer);
      stopFrames();
      stopProgress();
      resolve(isDrawn);
    };
    const isFinal = () => {
      const state = viewer.progress?.state;
      return state === "complete" || state === "limited";
    };
    const stopFrames = viewer.on("frame", ({ samplesDrawn }) => {
      if (samplesDrawn === 0) return;
      if (!isDrawn) {
        clearTimeout(timer);
        timer = setTimeout(end, limits.refining);
      }
      isDrawn = true;
      if (isFinal()) end();
    });
    const stopProgress = viewer.on("progress", () => {
      if (!isFinal()) return;
      isDrawn = true; // or there is nothing to draw
      end();
    });
    stop = end;
  });
  return { drawn, stop: () => stop() };
}

/** Whether the browser saves data. Not every browser states this; it then counts as off. */
export function savesData(): boolean {
  const { connection } = navigator as Navigator & {
    connection?: { saveData: boolean; effectiveType: string };
  };
  return connection !== undefined && (connection.saveData || connection.effectiveType !== "4g");
}
