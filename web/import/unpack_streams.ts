/** Decompresses files that are compressed as a whole. This is in the worker that unpacks, alone. */
import { Decompress } from "fzstd";
import bitsOf from "unbzip2-stream/lib/bit_iterator.js";
import bzip2 from "unbzip2-stream/lib/bzip2.js";
import xxhash from "xxhash-wasm";
import xz from "xz-decompress";
import type { Packing } from "./types.ts";
import { zstdFrames } from "./zstd_frames.ts";

/** Decompressed bytes are handed over in parts of this size. */
const partBytes = 1 << 20;

/** Is given the decompressed bytes in order; each part is its own. */
export type TakePart = (part: Uint8Array) => void;

/** Decompresses all of a file. Rejects if its data are damaged or end early. */
export function unpackStream(file: Blob, packing: Packing, take: TakePart): Promise<void> {
  return streams[packing](file, take);
}

const streams: Readonly<Record<Packing, (file: Blob, take: TakePart) => Promise<void>>> = {
  gzip: (file, take) => readAll(file.stream().pipeThrough(new DecompressionStream("gzip")), take),
  bzip2: unpackBzip2,
  xz: unpackXz,
  zstd: unpackZstd,
};

async function readAll(stream: ReadableStream<Uint8Array>, take: TakePart): Promise<void> {
  const reader = stream.getReader();
  for (;;) {
    const { done, value } = await reader.read();
    if (done) return;
    if (value.byteLength === 0) continue;
    try {
      take(value);
    } catch (error) {
      void reader.cancel().catch(() => {});
      throw error;
    }
  }
}

/** Frame by frame: the decoder does not compare their checksums. */
async function unpackZstd(file: Blob, take: TakePart): Promise<void> {
  const { create64 } = await xxhash();
  for await (const { begin, end, checksum } of zstdFrames(file)) {
    const hash = create64();
    const decoder = new Decompress((part) => {
      if (part.byteLength === 0) return;
      hash.update(part);
      take(part.slice()); // the decoder writes into its parts again
    });
    await readAll(file.slice(begin, end).stream(), (part) => decoder.push(part));
    decoder.push(new Uint8Array(), true);
    if (checksum !== undefined && Number(hash.digest() & 0xffffffffn) !== checksum) {
      throw new Error("a checksum of Zstandard differs");
    }
  }
}

async function unpackXz(file: Blob, take: TakePart): Promise<void> {
  const streamBytes = await xzStreamBytes(file);
  if (streamBytes !== file.size) throw new Error("the file has several xz streams");
  await readAll(new xz.XzReadableStream(file.stream()), take);
}

/**
 * The bytes of the xz stream that ends with a file: its footer has the size of its index, and that has
 * the sizes of its blocks (The .xz File Format 1.1, 2.1.2 and 4). The decoder ends with the first stream:
 * where it is not the only one, the rest would be lost.
 */
async function xzStreamBytes(file: Blob): Promise<number> {
  const bytesAt = async (begin: number, end: number) =>
    new Uint8Array(await file.slice(begin, end).arrayBuffer());
  const footerAt = file.size - 12;
  const footer = await bytesAt(Math.max(0, footerAt), file.size);
  if (footer.byteLength < 12 || footer[10] !== 0x59 || footer[11] !== 0x5a) {
    throw new Error("the last xz stream has no end");
  }
  const indexBytes = 4 * (new DataView(footer.buffer).getUint32(4, true) + 1);
  if (indexBytes > Math.min(footerAt, 64 << 20)) throw new Error("the index of xz is damaged");
  const index = await bytesAt(footerAt - indexBytes, footerAt);
  let at = 1;
  const next = (): number => {
    for (let value = 0, scale = 1; ; scale *= 128) {
      const byte = index[at++];
      if (byte === undefined || scale > 2 ** 49) throw new Error("the index of xz is damaged");
      value += (byte & 127) * scale;
      if (byte < 128) return value;
    }
  };
  let blocks = 0;
  for (let left = next(); left > 0; left--) {
    blocks += 4 * Math.ceil(next() / 4);
    next(); // what the block becomes
  }
  return 12 + blocks + indexBytes + 12;
}

/**
 * The decoder reads bits at once: a block is decoded when as many bytes are there as it can have. A
 * block of level n becomes n · 100,000 bytes and, with runs, 50 times as many.
 */
async function unpackBzip2(file: Blob, take: TakePart): Promise<void> {
  const waiting: Uint8Array[] = [new Uint8Array()];
  let received = 0;
  const bits = bitsOf(() => {
    const next = waiting.shift();
    if (!next) throw new Error("the data end early");
    return next;
  });
  let level = 0;
  let checksum = 0;
  let part = new Uint8Array(partBytes);
  let filled = 0;
  const flush = () => {
    if (filled > 0) take(part.subarray(0, filled));
    part = new Uint8Array(partBytes);
    filled = 0;
  };
  const put = (byte: number) => {
    part[filled++] = byte;
    if (filled === partBytes) flush();
  };
  const step = () => {
    if (level === 0) {
      level = bzip2.header(bits);
      checksum = 0;
      return;
    }
    const size = 100_000 * level;
    const sum = bzip2.decompress(bits, put, new Int32Array(size), size, checksum);
    if (sum === null) level = 0;
    else checksum = sum;
  };
  /** More than a block's bytes. */
  const enough = () => 25_000 + 102_000 * (level || 9);
  await readAll(file.stream(), (piece) => {
    waiting.push(piece);
    received += piece.byteLength;
    while (received - bits.bytesRead >= enough()) step();
  });
  while (bits.bytesRead < received || level !== 0) step();
  flush();
}
