/**
 * Decompresses files that are compressed as a whole. Only the worker that unpacks imports this file.
 */
import { Decompress } from "fzstd";
import { Inflate, type ZStream } from "pako";
import bitsOf from "unbzip2-stream/lib/bit_iterator.js";
import bzip2 from "unbzip2-stream/lib/bzip2.js";
import xxhash from "xxhash-wasm";
import xz from "xz-decompress";
import type { Packing } from "./types.ts";
import { xzStreams } from "./xz_streams.ts";
import { zstdFrames } from "./zstd_frames.ts";

/** Decompressed bytes are passed on in parts of this size. */
const partBytes = 1 << 20;

/** The largest window, and the header of gzip, as zlib's inflateInit2 takes them. */
const gzipOnly = 15 + 16;

/** Called with the decompressed bytes in order; it owns each part. */
export type TakePart = (part: Uint8Array) => void;

/** Decompresses a whole file. Rejects if its data are damaged or end early. */
export function unpackStream(file: Blob, packing: Packing, take: TakePart): Promise<void> {
  return streams[packing](file, take);
}

const streams: Readonly<Record<Packing, (file: Blob, take: TakePart) => Promise<void>>> = {
  gzip: unpackGzip,
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

/** The browser's decoder stops after the first member, but block gzip (BGZF) has thousands. */
async function unpackGzip(file: Blob, take: TakePart): Promise<void> {
  let member: Inflate | undefined;
  let state: ZStream | undefined;
  await readAll(file.stream(), (piece) => {
    for (let rest = piece; ; ) {
      // Zeros after a member are padding.
      if (member?.ended) rest = rest.subarray(firstOther(rest, 0));
      if (rest.byteLength === 0) return;
      if (!member || member.ended) {
        member = new Inflate({ windowBits: gzipOnly, chunkSize: partBytes });
        member.onStart = (stream) => {
          state = stream;
        };
        member.onData = take;
        member.onEnd = () => {};
      }
      if (!member.push(rest)) throw new Error(member.msg);
      rest = rest.subarray(rest.byteLength - (state?.avail_in ?? 0));
    }
  });
  if (!member?.ended) throw new Error("the data end early");
}

/** The index of the first byte that is not `value`. */
function firstOther(bytes: Uint8Array, value: number): number {
  const at = bytes.findIndex((byte) => byte !== value);
  return at < 0 ? bytes.byteLength : at;
}

/** Decodes frame by frame, because the decoder does not verify their checksums. */
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

/** Decodes stream by stream, because the decoder stops after the first one. */
async function unpackXz(file: Blob, take: TakePart): Promise<void> {
  for (const { begin, end } of await xzStreams(file)) {
    await readAll(new xz.XzReadableStream(file.slice(begin, end).stream()), take);
  }
}

/**
 * The decoder reads bits synchronously, so a block is decoded when the largest possible number of its
 * bytes is available. A block of level n becomes n · 100,000 bytes and, with runs, 50 times as many.
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
