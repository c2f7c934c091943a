import { applyPalette, GIFEncoder, quantize } from "gifenc";
import type { PictureSize } from "../viewer/types.ts";
import type { FilmFile } from "./film.ts";

/** The shortest time of a frame that browsers and slides show as it is (ms); GIF counts hundredths of a second. */
const shortestFrame = 20;
const colours = 256;

/** An animated GIF that plays in a loop. Each frame has the 256 colours that suit it best. */
export function gifFile({ width, height }: PictureSize, framesPerSecond: number): FilmFile {
  const gif = GIFEncoder();
  const delay = Math.max(shortestFrame, 10 * Math.round(100 / framesPerSecond));
  return {
    async add(rgba) {
      const palette = quantize(rgba, colours);
      const indices = applyPalette(rgba, palette);
      gif.writeFrame(indices, width, height, { palette, delay, repeat: 0 });
    },
    async finish() {
      gif.finish();
      return new Blob([gif.bytes()], { type: "image/gif" });
    },
    close() {},
  };
}
