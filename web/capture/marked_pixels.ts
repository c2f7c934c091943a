import type { PictureSize } from "../viewer/types.ts";

/** An SVG document of a part of the picture: its rows from `top`. `marks`: marksSvg. */
function document(marks: string, width: number, top: number, rows: number): string {
  return `<svg xmlns="http://www.w3.org/2000/svg" width="${width}" height="${rows}" viewBox="0 ${top} ${width} ${rows}">${marks}</svg>`;
}

/** Draws marks over rows of a picture (RGBA, not premultiplied). Pixels without a mark stay exactly the same. */
export async function drawMarks(
  rgba: Uint8ClampedArray,
  { width, height: rows }: PictureSize,
  top: number,
  marks: string,
): Promise<void> {
  const image = new Image(width, rows);
  image.src = `data:image/svg+xml,${encodeURIComponent(document(marks, width, top, rows))}`;
  await image.decode();
  const context = new OffscreenCanvas(width, rows).getContext("2d");
  if (!context) throw new Error("no 2D context");
  context.drawImage(image, 0, 0);
  const { data } = context.getImageData(0, 0, width, rows);
  for (let i = 0; i < data.length; i += 4) {
    const above = (data[i + 3] ?? 0) / 255;
    if (above === 0) continue;
    const below = ((rgba[i + 3] ?? 0) / 255) * (1 - above);
    const alpha = above + below;
    for (let c = i; c < i + 3; ++c) {
      rgba[c] = ((data[c] ?? 0) * above + (rgba[c] ?? 0) * below) / alpha;
    }
    rgba[i + 3] = 255 * alpha;
  }
}

/** An SVG document with the picture (PNG) and marks above it, which stay lines and letters. */
export async function svgWithPicture(
  picture: Blob,
  { width, height }: PictureSize,
  marks: string,
): Promise<Blob> {
  const address = await new Promise<string>((resolve, reject) => {
    const reader = new FileReader();
    reader.onload = () => resolve(String(reader.result));
    reader.onerror = () => reject(reader.error);
    reader.readAsDataURL(picture);
  });
  const image = `<image width="${width}" height="${height}" href="${address}"/>`;
  return new Blob([document(image + marks, width, 0, height)], { type: "image/svg+xml" });
}
