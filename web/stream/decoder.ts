import type { Core } from "../core/core.ts";
import type { Chunk } from "../core/records.ts";
import type { DecodedChunk } from "../core/types.ts";

/** The shape and checksum of a chunk, which decoding needs besides its bytes. */
export type DecodeJob = Pick<
  Chunk,
  "level" | "blockCells" | "bandBegin" | "bandEnd" | "cells" | "checksum"
>;

/** What decoding a field chunk needs besides: the samples of the store's chunk, and the bits of the field's values. */
export type FieldJob = DecodeJob & { field: { samples: Uint32Array; bits: 8 | 16 } };

/** Decodes chunks, on this thread or on others. */
export interface Decoder {
  /**
   * Checks and decodes a chunk. Takes ownership of the bytes: they may be transferred to a worker.
   * Rejects with a CoreError (checksum_mismatch, malformed_chunk, …) or the signal's reason.
   */
  decode(job: DecodeJob, bytes: Uint8Array, signal: AbortSignal): Promise<DecodedChunk>;
  /** The same for a field chunk: a PackedField for each sample, as Core.decodeField returns them. */
  decodeField(job: FieldJob, bytes: Uint8Array, signal: AbortSignal): Promise<Uint32Array>;
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
    await otherTasks(signal);
    return this.#core.decodeChunk(job, bytes);
  }

  async decodeField(job: FieldJob, bytes: Uint8Array, signal: AbortSignal): Promise<Uint32Array> {
    await otherTasks(signal);
    return this.#core.decodeField(job, bytes, job.field.samples, job.field.bits);
  }

  close(): void {}
}

/** Lets other tasks run between two chunks. */
async function otherTasks(signal: AbortSignal): Promise<void> {
  await new Promise((resolve) => setTimeout(resolve));
  signal.throwIfAborted();
}
