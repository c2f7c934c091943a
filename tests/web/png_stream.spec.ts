import { crc32, inflateSync } from "node:zlib";
import { describe, expect, it } from "vitest";
import { PngStream } from "../../web/capture/png_stream.ts";

interface Decoded {
  width: number;
  height: number;
  channels: number;
  pixels: number[];
}

/** Decodes a PNG with the filter Sub in all rows, and checks its checksums. */
async function decode(blob: Blob): Promise<Decoded> {
  const bytes = Buffer.from(await blob.arrayBuffer());
  expect([...bytes.subarray(0, 8)]).toEqual([137, 80, 78, 71, 13, 10, 26, 10]);
  const types: string[] = [];
  const data: Buffer[] = [];
  let header = Buffer.alloc(13);
  for (let at = 8; at < bytes.length; ) {
    const end = at + 8 + bytes.readUInt32BE(at);
    const type = bytes.toString("latin1", at + 4, at + 8);
    expect(bytes.readUInt32BE(end)).toBe(crc32(bytes.subarray(at + 4, end)));
    if (type === "IHDR") header = bytes.subarray(at + 8, end);
    if (type === "IDAT") data.push(bytes.subarray(at + 8, end));
    if (types.at(-1) !== type) types.push(type);
    at = end + 4;
  }
  expect(types).toEqual(["IHDR", "IDAT", "IEND"]);
  const [width, height] = [header.readUInt32BE(0), header.readUInt32BE(4)];
  const channels = header[9] === 6 ? 4 : 3;
  const rows = inflateSync(Buffer.concat(data));
  const pixels: number[] = [];
  const rowBytes = width * channels;
  expect(rows.length).toBe(height * (1 + rowBytes));
  for (let y = 0; y < height; ++y) {
    const row = rows.subarray(y * (1 + rowBytes), (y + 1) * (1 + rowBytes));
    expect(row[0]).toBe(1);
    const values = [...row.subarray(1)];
    for (let i = channels; i < rowBytes; ++i) {
      values[i] = ((values[i] ?? 0) + (values[i - channels] ?? 0)) & 255;
    }
    for (const value of values) pixels.push(value);
  }
  return { width, height, channels, pixels };
}

const width = 7;
const height = 5;
const rgba = Uint8ClampedArray.from({ length: 4 * width * height }, (_, i) => (i * i * 31) % 256);

describe("a PNG that is written row by row", () => {
  it("has the pixels of all calls", async () => {
    const png = new PngStream(width, height, true);
    await png.addRows(rgba.subarray(0, 8 * width));
    await png.addRows(rgba.subarray(8 * width));
    const decoded = await decode(await png.finish());
    expect(decoded).toEqual({ width, height, channels: 4, pixels: [...rgba] });
  });

  it("has no alpha if it is opaque", async () => {
    const png = new PngStream(width, height, false);
    await png.addRows(rgba);
    const { channels, pixels } = await decode(await png.finish());
    expect(channels).toBe(3);
    expect(pixels).toEqual([...rgba].filter((_, i) => i % 4 !== 3));
  });

  it("splits large data into chunks", async () => {
    const noise = new Uint8ClampedArray(4 * 1024 * 700);
    let state = 1;
    for (let i = 0; i < noise.length; ++i) {
      state = (state * 1_103_515_245 + 12_345) % 2 ** 31;
      noise[i] = state >> 16;
    }
    const png = new PngStream(1024, 700, true);
    await png.addRows(noise);
    const { pixels } = await decode(await png.finish());
    expect(Buffer.from(pixels).equals(Buffer.from(noise))).toBe(true);
  });

  it("refuses parts of rows, and too many or too few of them", async () => {
    const png = new PngStream(width, height, true);
    await expect(png.addRows(rgba.subarray(4))).rejects.toThrow("whole rows of 28 bytes");
    await png.addRows(rgba.subarray(0, 4 * width));
    await expect(png.finish()).rejects.toThrow("expected 5 rows, found 1");
    await expect(png.addRows(rgba)).rejects.toThrow("at most 4");
  });
});
