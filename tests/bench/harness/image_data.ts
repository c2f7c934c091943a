import { readFileSync } from "node:fs";
import { inflateSync } from "node:zlib";

/**
 * The values of the one array of a VTK image data file, as its bytes. Supports the encodings of the
 * inputs here: zlib blocks, in base64 or appended raw.
 *
 *   number of blocks | bytes of a block | of the last, if shorter | compressed bytes of each | blocks
 */
export function imageData(path: string): Buffer {
  const file = readFileSync(path);
  const text = file.toString("latin1");
  if (!text.includes('compressor="vtkZLibDataCompressor"')) throw new Error(`${path}: not zlib`);
  const wide = text.includes('header_type="UInt64"');
  const word = wide ? 8 : 4;
  const number = (bytes: Buffer, index: number): number =>
    wide ? Number(bytes.readBigUInt64LE(8 * index)) : bytes.readUInt32LE(4 * index);

  let head: Buffer;
  let blocks: Buffer;
  const appended = text.indexOf("<AppendedData");
  if (appended >= 0) {
    head = file.subarray(text.indexOf("_", appended) + 1);
    blocks = head.subarray((3 + number(head, 0)) * word);
  } else {
    // Head and blocks are encoded separately.
    const array = text.slice(text.indexOf(">", text.indexOf("<DataArray")) + 1).trimStart();
    head = Buffer.from(array.slice(0, 4 * Math.ceil(word / 3)), "base64");
    const headerLength = 4 * Math.ceil(((3 + number(head, 0)) * word) / 3);
    head = Buffer.from(array.slice(0, headerLength), "base64");
    blocks = Buffer.from(array.slice(headerLength, array.indexOf("<")), "base64");
  }
  const parts: Buffer[] = [];
  for (let i = 0, at = 0; i < number(head, 0); ++i) {
    const bytes = number(head, 3 + i);
    parts.push(inflateSync(blocks.subarray(at, at + bytes)));
    at += bytes;
  }
  return Buffer.concat(parts);
}
