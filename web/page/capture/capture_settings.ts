import type { FrameView } from "../../capture/frame_paths.ts";
import { cameraPath, sweep, throughTime, turntable } from "../../capture/frame_paths.ts";
import { mostPixels } from "../../capture/picture.ts";
import type { VideoFormat } from "../../capture/video_file.ts";
import { captureTexts } from "../../texts/capture.ts";
import { localized } from "../../texts/numbers.ts";
import type { Camera, PictureSize } from "../../viewer/types.ts";

import type { MarkName } from "./shown_marks.ts";

export type What = "picture" | "turntable" | "sweep" | "path" | "time";

/** The settings of the dialog for pictures and films. */
export interface CaptureSettings {
  what: What;
  /** A name of sizeChoices(), or "own". */
  sizeName: string;
  own: PictureSize;
  transparent: boolean;
  marks: ReadonlySet<MarkName>;
  /** Of a picture: svg has the marks as lines and letters above a PNG. */
  pictureFormat: "png" | "svg";
  seconds: number;
  framesPerSecond: number;
  format: VideoFormat | "gif" | "png";
  /** Isovalues of the sweep. */
  from: number;
  to: number;
  /** The camera views of the path. */
  cameras: readonly Camera[];
}

export interface SizeChoice {
  name: string;
  label: string;
  size: PictureSize;
}

const mostFrames = 3600;

/** The sizes to choose from; `shown`: the size of the canvas. */
export function sizeChoices({ width, height }: PictureSize): SizeChoice[] {
  const all = [
    { name: "shown", label: captureTexts.asShown, size: { width, height } },
    ...[2, 4].map((times) => ({
      name: `${times}`,
      label: captureTexts.timesShown(times),
      size: { width: times * width, height: times * height },
    })),
    { name: "hd", label: "Full HD", size: { width: 1920, height: 1080 } },
    { name: "4k", label: "4K", size: { width: 3840, height: 2160 } },
    { name: "8k", label: "8K", size: { width: 7680, height: 4320 } },
  ];
  return all.filter(({ size }) => Math.max(size.width, size.height) <= mostPixels);
}

/** The chosen size. Videos have even sizes. */
export function chosenSize(settings: CaptureSettings, shown: PictureSize): PictureSize {
  const { sizeName, own, what, format } = settings;
  const { width, height } = sizeChoices(shown).find(({ name }) => name === sizeName)?.size ?? own;
  if (what === "picture" || format === "png" || format === "gif") return { width, height };
  return { width: width - (width % 2), height: height - (height % 2) };
}

export function frameCount({ seconds, framesPerSecond }: CaptureSettings): number {
  return Math.round(seconds * framesPerSecond);
}

/** Why the settings are invalid; undefined if they are valid. */
export function problemOf(settings: CaptureSettings, shown: PictureSize): string | undefined {
  const { width, height } = chosenSize(settings, shown);
  const isFine = (px: number) => Number.isInteger(px) && px >= 1 && px <= mostPixels;
  if (!isFine(width) || !isFine(height)) {
    return captureTexts.wrongSize(mostPixels);
  }
  if (settings.what === "picture") return undefined;
  const frames = frameCount(settings);
  if (!(frames >= 2 && frames <= mostFrames)) {
    const most = localized(String(mostFrames / settings.framesPerSecond));
    return captureTexts.wrongSeconds(most, settings.framesPerSecond);
  }
  if (settings.what === "sweep" && !Number.isFinite(settings.from + settings.to)) {
    return captureTexts.wrongIsovalues;
  }
  if (settings.what === "path" && settings.cameras.length < 2) {
    return captureTexts.tooFewViews;
  }
  return undefined;
}

/** The frames of the film. `surface`: the one whose isovalue changes; `steps`: those of the scene. */
export function framesOf(
  settings: CaptureSettings,
  view: FrameView,
  surface: number,
  steps: number,
): FrameView[] {
  const frames = frameCount(settings);
  if (settings.what === "time") return throughTime(view, steps, frames);
  if (settings.what === "sweep") return sweep(view, surface, [settings.from, settings.to], frames);
  if (settings.what === "path") return cameraPath(settings.cameras, view, frames);
  return turntable(view, frames);
}
