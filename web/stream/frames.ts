import { type ChunkPlaceInFile, PartError } from "./source.ts";
import { TransferError } from "./transfer.ts";

const headerBytes = 48;
const alignment = 16;

/**
 * Splits a response of many chunks while it arrives. Frames arrive in the requested order
 * (server/HTTP.md):
 *
 *     byte  0        4        8       12       16       20       24       28
 *          +--------+--------+--------+--------+--------+--------+--------+--------+
 *          | bytes  | status | level  |   x    |   y    |   z    |  band  | cells  |
 *          +--------+--------+--------+--------+--------+--------+--------+--------+
 *       32 | begin  |  end   |checksum|   0    | 48: the chunk's bytes, padded to 16
 *          +--------+--------+--------+--------+
 */
export class FrameReader<C extends ChunkPlaceInFile> {
  readonly #chunks: readonly C[];
  readonly #arrived: (chunk: C, bytes: Uint8Array) => void;
  #next = 0;
  readonly #header = new Uint8Array(headerBytes);
  /** The bytes of the arriving chunk, in a separate array; undefined between chunks. */
  #chunk: Uint8Array | undefined;
  /** Number of bytes that have arrived of the present header, or of the chunk and its padding. */
  #have = 0;

  constructor(chunks: readonly C[], arrived: (chunk: C, bytes: Uint8Array) => void) {
    this.#chunks = chunks;
    this.#arrived = arrived;
  }

  add(part: Uint8Array): void {
    let at = 0;
    while (at < part.length) {
      const chunk = this.#chunk;
      const size = chunk ? padded(chunk.length) : headerBytes;
      const received = part.subarray(at, at + size - this.#have);
      const room = (chunk ?? this.#header).length - this.#have;
      if (room > 0) (chunk ?? this.#header).set(received.subarray(0, room), this.#have);
      this.#have += received.length;
      at += received.length;
      if (this.#have < size) continue;
      this.#have = 0;
      if (chunk) this.#finishChunk(chunk);
      else this.#readHeader();
    }
  }

  /** The response has ended: all chunks must have arrived. */
  end(): void {
    if (this.#next < this.#chunks.length) {
      throw new TransferError(
        "unreachable",
        `expected ${this.#chunks.length} chunks, found ${this.#next}: the response is incomplete`,
      );
    }
  }

  #readHeader(): void {
    const chunk = this.#chunks[this.#next];
    const header = new DataView(this.#header.buffer);
    const word = (i: number): number => header.getUint32(4 * i, true);
    const status = word(1);
    const isNamed =
      chunk !== undefined &&
      word(2) === chunk.level &&
      chunk.block.every((index, axis) => word(3 + axis) === index) &&
      word(6) === chunk.band;
    if (isNamed && status !== 0) {
      const name = `${word(2)}/${word(3)}.${word(4)}.${word(5)}/${word(6)}`;
      throw new PartError(
        chunk.handle,
        `the server cannot read chunk ${name} (status ${status} of the core)`,
      );
    }
    if (!isNamed || word(0) !== chunk.bytes) {
      throw new TransferError(
        "server-fault",
        "the response does not contain the requested chunks: the bytes were changed in transit, or the " +
          "server is not an Isosplat server",
      );
    }
    this.#chunk = new Uint8Array(chunk.bytes);
  }

  #finishChunk(bytes: Uint8Array): void {
    const chunk = this.#chunks[this.#next++];
    this.#chunk = undefined;
    if (chunk) this.#arrived(chunk, bytes);
  }
}

function padded(bytes: number): number {
  return Math.ceil(bytes / alignment) * alignment;
}
