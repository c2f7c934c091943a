import type { Chunk } from "../core/index.ts";
import { type Core, CoreError } from "../core/index.ts";

/** What decoding a chunk takes: its shape, and what its bytes have to hash to. */
export type DecodeJob = Pick<
  Chunk,
  "level" | "blockCells" | "bandBegin" | "bandEnd" | "cells" | "checksum"
>;

/** Turns chunks into samples, somewhere. */
export interface Decoder {
  /**
   * Checks and decodes a chunk to PackedSamples, four words each. Takes the bytes: they may be
   * transferred away. Rejects with a CoreError (checksum_mismatch, malformed_chunk, …) or the
   * signal's reason.
   */
  decode(job: DecodeJob, bytes: Uint8Array, signal: AbortSignal): Promise<Uint32Array>;
  /** Ends its threads and frees its memory. */
  close(): void;
}

/** The check and the decoding, wherever they run. */
export function decodeChecked(core: Core, job: DecodeJob, bytes: Uint8Array): Uint32Array {
  const found = core.checksum(bytes);
  if (found !== job.checksum) {
    const hex = (word: number): string => `0x${word.toString(16).padStart(8, "0")}`;
    throw new CoreError(
      "checksum_mismatch",
      `checksum differs (expected ${hex(job.checksum)}, found ${hex(found)})`,
    );
  }
  return core.decodePacked(job, bytes);
}

/** Decodes on the calling thread: for Node, and where workers are not to be had. */
export class InlineDecoder implements Decoder {
  readonly #core: Core;

  constructor(core: Core) {
    this.#core = core;
  }

  async decode(job: DecodeJob, bytes: Uint8Array, signal: AbortSignal): Promise<Uint32Array> {
    // Others get their turn between two chunks.
    await new Promise((resolve) => setTimeout(resolve));
    signal.throwIfAborted();
    return decodeChecked(this.#core, job, bytes);
  }

  close(): void {}
}
