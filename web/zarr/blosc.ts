import { decompress as decodeZstd } from "fzstd";
import { inflate } from "./inflate.ts";
import { decodeBloscLz, decodeLz4 } from "./lz_blocks.ts";

// A chunk of Blosc 1:
//
//   0        1        2        3          4        8           12       16
//   version  version  flags    bytes of   bytes    bytes of    bytes,   offset of   the blocks
//   (Blosc)  (codec)           an element          a block     packed   each block
//
// A block has its bytes in streams, each with its packed size before it: one for each byte of the
// elements, or a single one. Its elements may be shuffled: first all first bytes, then all second
// ones; or the same with bits.

const headerBytes = 16;
const isShuffled = 1;
const isCopied = 2;
const isBitShuffled = 4;
const isWhole = 16;
/**
 * Blocks are split into streams if elements have at most this size, and a block at least this number of
 * elements.
 */
const maxStreams = 16;
const minStreamBytes = 128;

type Decode = (bytes: Uint8Array, size: number) => Uint8Array | Promise<Uint8Array>;

/** By the upper three bits of the flags. */
const codecs: readonly (Decode | undefined)[] = [
  decodeBloscLz,
  decodeLz4,
  undefined, // Snappy
  (bytes, size) => inflate(bytes, "deflate", size),
  (bytes, size) => decodeZstd(bytes, new Uint8Array(size)),
];

/** Decodes a chunk of Blosc 1 of at most `most` bytes. Rejects if it is damaged. */
export async function decodeBlosc(chunk: Uint8Array, most: number): Promise<Uint8Array> {
  if (chunk.length < headerBytes) throw new Error("a chunk of Blosc is cut short");
  const view = new DataView(chunk.buffer, chunk.byteOffset, chunk.byteLength);
  const [flags, elementBytes] = [view.getUint8(2), view.getUint8(3)];
  const [bytes, blockBytes] = [view.getUint32(4, true), view.getUint32(8, true)];
  if (bytes > most) throw new Error(`expected at most ${most} bytes in a chunk, found ${bytes}`);
  if (flags & isCopied) {
    if (chunk.length < headerBytes + bytes) throw new Error("a chunk of Blosc is cut short");
    return chunk.slice(headerBytes, headerBytes + bytes);
  }
  const decode = codecs[flags >> 5];
  if (!decode) throw new Error(`the codec ${flags >> 5} of Blosc is not read: compress it anew`);
  if (blockBytes === 0 || elementBytes === 0) throw new Error("the header of Blosc is not valid");
  const whole = new Uint8Array(bytes);
  for (let begin = 0, block = 0; begin < bytes; begin += blockBytes, ++block) {
    const size = Math.min(blockBytes, bytes - begin);
    const isSplit =
      !(flags & isWhole) &&
      elementBytes <= maxStreams &&
      size === blockBytes &&
      size / elementBytes >= minStreamBytes;
    const streams = isSplit ? elementBytes : 1;
    const streamBytes = Math.floor(size / streams);
    const packed = new Uint8Array(size);
    let at = view.getUint32(headerBytes + 4 * block, true);
    for (let stream = 0; stream < streams; ++stream) {
      const count = view.getUint32(at, true);
      at += 4;
      if (at + count > chunk.length) throw new Error("a chunk of Blosc is cut short");
      const part = chunk.subarray(at, at + count);
      const decoded = count === streamBytes ? part : await decode(part, streamBytes);
      if (decoded.length !== streamBytes) throw new Error("a chunk of Blosc is damaged");
      packed.set(decoded, stream * streamBytes);
      at += count;
    }
    const target = whole.subarray(begin, begin + size);
    if (flags & isShuffled && elementBytes > 1) unshuffle(packed, elementBytes, target);
    else if (flags & isBitShuffled && size >= elementBytes)
      unshuffleBits(packed, elementBytes, target);
    else target.set(packed);
  }
  return whole;
}

function unshuffle(from: Uint8Array, elementBytes: number, to: Uint8Array): void {
  const elements = Math.floor(from.length / elementBytes);
  for (let byte = 0; byte < elementBytes; ++byte) {
    const plane = byte * elements;
    for (let i = 0; i < elements; ++i) to[i * elementBytes + byte] = from[plane + i] as number;
  }
  to.set(from.subarray(elements * elementBytes), elements * elementBytes);
}

/** Blocks whose number of elements is not a multiple of 8 are not shuffled. */
function unshuffleBits(from: Uint8Array, elementBytes: number, to: Uint8Array): void {
  const elements = Math.floor(from.length / elementBytes);
  to.set(from);
  if (elements % 8 !== 0) return;
  to.fill(0, 0, elements * elementBytes);
  const planeBytes = elements / 8;
  for (let byte = 0; byte < elementBytes; ++byte) {
    for (let bit = 0; bit < 8; ++bit) {
      const plane = (byte * 8 + bit) * planeBytes;
      for (let i = 0; i < elements; ++i) {
        const value = ((from[plane + (i >> 3)] as number) >> (i & 7)) & 1;
        to[i * elementBytes + byte] = (to[i * elementBytes + byte] as number) | (value << bit);
      }
    }
  }
}
