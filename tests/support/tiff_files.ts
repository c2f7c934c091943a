/** Writes TIFF stacks, according to the TIFF 6.0 specification. */
import { deflateSync } from "node:zlib";

export interface TiffForm {
  width: number;
  height: number;
  bits: 8 | 16 | 32;
  /** 1: unsigned, 2: signed, 3: floating-point. */
  format: 1 | 2 | 3;
  bigEndian?: boolean;
  /** 1: none, 8: Deflate, 32773: PackBits. For other values, the voxels are not compressed. */
  compression?: number;
  rowsPerStrip?: number;
  description?: string;
  pixelsPerUnit?: number;
}

/** PackBits with literal runs only. */
export function packed(bytes: Uint8Array): Uint8Array {
  const parts: number[] = [];
  for (let i = 0; i < bytes.length; i += 128) {
    const run = bytes.subarray(i, i + 128);
    parts.push(run.length - 1, ...run);
  }
  return Uint8Array.from(parts);
}

function compressed(bytes: Uint8Array, compression: number): Uint8Array {
  return compression === 8 ? deflateSync(bytes) : compression === 32773 ? packed(bytes) : bytes;
}

/** A stack of little-endian voxels as a classic TIFF file with a page per slice. */
export function tiffOf(form: TiffForm, voxels: Uint8Array): Uint8Array {
  const { width, height, bits, format, bigEndian = false, compression = 1 } = form;
  const rows = form.rowsPerStrip ?? height;
  const rowBytes = (width * bits) / 8;
  const pageBytes = rowBytes * height;
  const chunks: Uint8Array[] = [];
  let size = 0;
  const append = (bytes: Uint8Array): number => {
    const at = size;
    const even = bytes.length % 2 === 0 ? bytes : Buffer.concat([bytes, Buffer.alloc(1)]);
    chunks.push(even);
    size += even.length;
    return at;
  };
  const number = (value: number, bytes: 2 | 4): Buffer => {
    const out = Buffer.alloc(bytes);
    if (bigEndian) out.writeUIntBE(value, 0, bytes);
    else out.writeUIntLE(value, 0, bytes);
    return out;
  };
  const header = Buffer.concat([Buffer.from(bigEndian ? "MM" : "II"), number(42, 2), number(0, 4)]);
  append(header);
  let link: Buffer = header.subarray(4);
  for (let page = 0; page * pageBytes < voxels.length; ++page) {
    const slice = Buffer.from(voxels.subarray(page * pageBytes, (page + 1) * pageBytes));
    if (bigEndian && bits === 16) slice.swap16();
    if (bigEndian && bits === 32) slice.swap32();
    const offsets: Buffer[] = [];
    const sizes: Buffer[] = [];
    for (let row = 0; row < height; row += rows) {
      const strip = slice.subarray(row * rowBytes, (row + rows) * rowBytes);
      const bytes = compressed(strip, compression);
      offsets.push(number(append(bytes), 4));
      sizes.push(number(bytes.length, 4));
    }
    const entries: Buffer[] = [];
    const entry = (tag: number, type: 2 | 3 | 4 | 5, count: number, value: Buffer): void => {
      const inside = Buffer.concat([value, Buffer.alloc(4)]).subarray(0, 4);
      const field = value.length > 4 ? number(append(value), 4) : inside;
      entries.push(Buffer.concat([number(tag, 2), number(type, 2), number(count, 4), field]));
    };
    entry(256, 4, 1, number(width, 4));
    entry(257, 4, 1, number(height, 4));
    entry(258, 3, 1, number(bits, 2));
    entry(259, 3, 1, number(compression, 2));
    entry(262, 3, 1, number(1, 2));
    const text = page === 0 ? (form.description ?? "") : "";
    if (text) entry(270, 2, Buffer.byteLength(text) + 1, Buffer.from(`${text}\0`));
    entry(273, 4, offsets.length, Buffer.concat(offsets));
    entry(277, 3, 1, number(1, 2));
    entry(278, 4, 1, number(rows, 4));
    entry(279, 4, sizes.length, Buffer.concat(sizes));
    if (form.pixelsPerUnit) {
      const ratio = Buffer.concat([
        number(Math.round(form.pixelsPerUnit * 1000), 4),
        number(1000, 4),
      ]);
      entry(282, 5, 1, ratio);
      entry(283, 5, 1, ratio);
    }
    entry(339, 3, 1, number(format, 2));
    const next = number(0, 4);
    number(size, 4).copy(link);
    append(Buffer.concat([number(entries.length, 2), ...entries, next]));
    link = (chunks.at(-1) as Buffer).subarray(-4);
  }
  return Buffer.concat(chunks);
}
