import type { Core } from "../core/core.ts";
import type { Chunk } from "../core/records.ts";
import type { DecodedChunk } from "../core/types.ts";

/** The shape and checksum of a chunk, which decoding needs besides its bytes. */
export type DecodeJob = Pick<
  Chunk,
  "level" | "blockCells" | "bandBegin" | "bandEnd" | "cells" | "checksum"
>;

/** Decodes chunks, on this thread or on others. */
export interface Decoder {
  /**
   * Checks and decodes a chunk. Takes ownership of the bytes: they may be transferred to a worker.
   * Rejects with a CoreError (checksum_mismatch, malformed_chunk, …) or the signal's reason.
   */
  decode(job: DecodeJob, bytes: Uint8Array, signal: AbortSignal): Promise<DecodedChunk>;
  /** Ends the decoder's threads and frees its memory. */
  close(): void;
}

/** Decodes on the calling thread, for Node and for environments without workers. */
export class InlineDecoder implements Decoder {
  readonly #core: Core;

  constructor(core: Core) {
    this.#core = core;
  }

  async decode(job: DecodeJob, bytes: Uint8Array, signal: AbortSignal): Promise<DecodedChunk> {
    // Let other tasks run between two chunks.
    await new Promise((resolve) => setTimeout(resolve));
    signal.throwIfAborted();
    return this.#core.decodeChunk(job, bytes);
  }

  close(): void {}
}
