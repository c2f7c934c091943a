import type { PictureSize } from "../viewer/types.ts";

const bitsPerPixel = 0.12;

/** Bits per second. */
export function bitRate({ width, height }: PictureSize, framesPerSecond: number): number {
  return Math.max(1e6, Math.round(bitsPerPixel * width * height * framesPerSecond));
}

/** Whether this browser can encode videos. */
export function canEncode(): boolean {
  return typeof VideoEncoder !== "undefined";
}
