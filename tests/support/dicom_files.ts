/** Writes DICOM slices with run lengths (RLE), and segmentations, according to PS3.5 and PS3.10. */
import { packed } from "./tiff_files.ts";

function element(tag: number, vr: string, value: Uint8Array | string): Buffer {
  const pad = vr === "UI" || vr === "OB" ? "\0" : " ";
  const bytes = Buffer.from(value as string);
  const even = bytes.length % 2 === 0 ? bytes : Buffer.concat([bytes, Buffer.from(pad)]);
  const isLong = vr === "OB" || vr === "SQ";
  const head = Buffer.alloc(isLong ? 12 : 8);
  head.writeUInt16LE(tag >>> 16, 0);
  head.writeUInt16LE(tag & 0xffff, 2);
  head.write(vr, 4, "latin1");
  if (isLong) head.writeUInt32LE(even.length, 8);
  else head.writeUInt16LE(even.length, 6);
  return Buffer.concat([head, even]);
}

function item(tag: number, bytes: Uint8Array): Buffer {
  const head = Buffer.alloc(8);
  head.writeUInt16LE(tag >>> 16, 0);
  head.writeUInt16LE(tag & 0xffff, 2);
  head.writeUInt32LE(bytes.length, 4);
  return Buffer.concat([head, bytes]);
}

/** The two bytes of unsigned pixels as run lengths: the high ones, then the low ones. */
function runLengths(pixels: Uint16Array): Uint8Array {
  const high = packed(Uint8Array.from(pixels, (pixel) => pixel >> 8));
  const low = packed(Uint8Array.from(pixels, (pixel) => pixel & 255));
  const even = (bytes: Uint8Array) => Buffer.concat([bytes, Buffer.alloc(bytes.length % 2)]);
  const head = Buffer.alloc(64);
  head.writeUInt32LE(2, 0);
  head.writeUInt32LE(64, 4);
  head.writeUInt32LE(64 + even(high).length, 8);
  return Buffer.concat([head, even(high), even(low)]);
}

/** A sequence. Each of `items` has the elements of one item. */
function sequence(tag: number, ...items: Uint8Array[][]): Buffer {
  return element(
    tag,
    "SQ",
    Buffer.concat(items.map((parts) => item(0xfffee000, Buffer.concat(parts)))),
  );
}

const number = (value: number): Buffer => Buffer.from(Uint16Array.of(value).buffer);

/** The beginning of a file. */
function fileStart(syntax: string): Buffer {
  const meta = element(0x00020010, "UI", syntax);
  const group = Buffer.alloc(4);
  group.writeUInt32LE(meta.length);
  return Buffer.concat([
    Buffer.alloc(128),
    Buffer.from("DICM"),
    element(0x00020000, "UL", group),
    meta,
  ]);
}

/** A frame of a segmentation, whose pixels are 0 or 1. */
export interface SegmentFrame {
  segment: number;
  z: number;
  pixels: readonly number[];
}

/** A BINARY segmentation with slices 1 mm apart, and segments "part 1", "part 2", … */
export function dicomSegmentation(
  frames: readonly SegmentFrame[],
  columns: number,
  rows: number,
): Uint8Array {
  const bits = frames.flatMap(({ pixels }) => pixels);
  const packedBits = Buffer.alloc(Math.ceil(bits.length / 8));
  for (const [i, bit] of bits.entries()) {
    packedBits[i >> 3] = (packedBits[i >> 3] as number) | (bit << (i & 7));
  }
  const segments = [...new Set(frames.map(({ segment }) => segment))];
  return Buffer.concat([
    fileStart("1.2.840.10008.1.2.1"),
    element(0x00080016, "UI", "1.2.840.10008.5.1.4.1.1.66.4"),
    element(0x00080060, "CS", "SEG"),
    element(0x00280002, "US", number(1)),
    element(0x00280004, "CS", "MONOCHROME2"),
    element(0x00280008, "IS", String(frames.length)),
    element(0x00280010, "US", number(rows)),
    element(0x00280011, "US", number(columns)),
    element(0x00280100, "US", number(1)),
    element(0x00280101, "US", number(1)),
    element(0x00280102, "US", number(0)),
    element(0x00280103, "US", number(0)),
    element(0x00620001, "CS", "BINARY"),
    sequence(
      0x00620002,
      ...segments.map((segment) => [
        element(0x00620004, "US", number(segment)),
        element(0x00620005, "LO", `part ${segment}`),
      ]),
    ),
    sequence(0x52009229, [
      sequence(0x00209116, [element(0x00200037, "DS", "1\\0\\0\\0\\1\\0")]),
      sequence(0x00289110, [
        element(0x00180088, "DS", "1"),
        element(0x00280030, "DS", "0.5\\0.75"),
      ]),
    ]),
    sequence(
      0x52009230,
      ...frames.map(({ segment, z }) => [
        sequence(0x00209113, [element(0x00200032, "DS", `0\\0\\${z}`)]),
        sequence(0x0062000a, [element(0x0062000b, "US", number(segment))]),
      ]),
    ),
    element(0x7fe00010, "OB", packedBits),
  ]);
}

/**
 * A CT slice at `z` mm. `syntax`: the transfer syntax that the file states. The pixels are always
 * run lengths.
 */
export function dicomSlice(
  pixels: Uint16Array,
  columns: number,
  z: number,
  syntax = "1.2.840.10008.1.2.5",
  series = { uid: "1.2.3.4", date: "20110305", description: "Thorax" },
): Uint8Array {
  const pixelData = Buffer.from("e07f10004f420000ffffffff", "hex");
  return Buffer.concat([
    fileStart(syntax),
    element(0x00080016, "UI", "1.2.840.10008.5.1.4.1.1.2"),
    element(0x00080018, "UI", `${series.uid}.${z}`),
    element(0x00080021, "DA", series.date),
    element(0x00080060, "CS", "CT"),
    element(0x0008103e, "LO", series.description),
    element(0x0020000e, "UI", series.uid),
    element(0x00200013, "IS", String(z)),
    element(0x00200032, "DS", `0\\0\\${z}`),
    element(0x00200037, "DS", "1\\0\\0\\0\\1\\0"),
    element(0x00280002, "US", number(1)),
    element(0x00280004, "CS", "MONOCHROME2"),
    element(0x00280010, "US", number(pixels.length / columns)),
    element(0x00280011, "US", number(columns)),
    element(0x00280030, "DS", "0.5\\0.75"),
    element(0x00280100, "US", number(16)),
    element(0x00280101, "US", number(16)),
    element(0x00280102, "US", number(15)),
    element(0x00280103, "US", number(0)),
    element(0x00281052, "DS", "-1024"),
    element(0x00281053, "DS", "2"),
    pixelData,
    item(0xfffee000, new Uint8Array(0)),
    item(0xfffee000, runLengths(pixels)),
    item(0xfffee0dd, new Uint8Array(0)),
  ]);
}
