import { downloadZip } from "client-zip";
import type { PictureSize } from "../viewer/types.ts";
import type { FilmFile } from "./film.ts";
import { PngStream } from "./png_stream.ts";

/** A ZIP of frame-0001.png and so on. */
export function pngSequence({ width, height }: PictureSize): FilmFile {
  const frames: Blob[] = [];
  return {
    async add(rgba) {
      const png = new PngStream(width, height, false);
      await png.addRows(rgba);
      frames.push(await png.finish());
    },
    finish() {
      const files = frames.map((input, i) => ({
        name: `frame-${String(i + 1).padStart(4, "0")}.png`,
        input,
      }));
      return downloadZip(files).blob();
    },
    close() {
      frames.length = 0;
    },
  };
}
