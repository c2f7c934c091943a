import {
  chunkShapeBytes,
  decodedClusters,
  decodedSamples,
  packedSampleBytes,
  pointsNormals,
  pointsPositions,
  writeChunkShape,
} from "../../build/wasm/web/layouts.js";
import type { CoreModule } from "./module.ts";
import { type Chunk, recordOf } from "./records.ts";
import { textAt } from "./text.ts";
import type { DecodedChunk, Points, Triple } from "./types.ts";

/**
 * A call into the core failed. `status`, for programs, is the name in shared/core/base/status.h; the message, for
 * people, does not have it.
 */
export class CoreError extends Error {
  override readonly name = "CoreError";
  readonly status: string;
  constructor(status: string, message: string) {
    super(message);
    this.status = status;
  }
}

/** The fields of a chunk that decoding needs besides the bytes. */
export type ChunkShape = Pick<Chunk, "level" | "blockCells" | "bandBegin" | "bandEnd" | "cells">;

/**
 * Calls of the core that pass memory. Copies of arguments are freed after the call. The heap is read
 * again for each result, since a call may replace it.
 */
export class Calls {
  readonly module: CoreModule;
  #core: number;

  constructor(module: CoreModule, core = module._isosplat_core_create()) {
    this.module = module;
    this.#core = core;
  }

  /** The IsosplatCore. Throws a CoreError after close(). */
  get core(): number {
    if (this.#core === 0) throw new CoreError("invalid_argument", "the store has been closed");
    return this.#core;
  }

  check(status: number): void {
    if (status === 0) return;
    throw new CoreError(
      textAt(this.module, this.module._isosplat_core_status_name(status)),
      textAt(this.module, this.module._isosplat_core_error(this.core)),
    );
  }

  /** A result buffer. It is valid until the next call. */
  result(buffer: number): Uint8Array {
    const at = this.module._isosplat_core_result(this.core, buffer);
    const bytes = this.module._isosplat_core_result_bytes(this.core, buffer);
    return this.module.HEAPU8.subarray(at, at + bytes);
  }

  /** A copy of a result buffer of floats. */
  floats(buffer: number): Float32Array {
    return new Float32Array(this.result(buffer).slice().buffer);
  }

  /** The results of a projection. */
  points(): Points {
    const positions = this.floats(pointsPositions);
    return { count: positions.length / 3, positions, normals: this.floats(pointsNormals) };
  }

  withBytes(bytes: Uint8Array, use: (at: number) => void): void {
    const at = copyIn(this.module, bytes);
    try {
      use(at);
    } finally {
      this.module._free(at);
    }
  }

  /** Passes the bytes of a chunk, and its IsosplatChunkShape. */
  withChunk(
    chunk: ChunkShape & { block?: Triple },
    bytes: Uint8Array,
    use: (at: number, shape: number) => void,
  ): void {
    const { level, blockCells, bandBegin, bandEnd, cells, block = [0, 0, 0] } = chunk;
    const record = { level, blockCells, bandBegin, bandEnd, cells, block };
    this.withBytes(bytes, (at) =>
      this.withBytes(recordOf(chunkShapeBytes, writeChunkShape, record), (shape) => use(at, shape)),
    );
  }

  decodePacked(shape: ChunkShape, bytes: Uint8Array): Uint32Array {
    this.withChunk(shape, bytes, (at, shapeAt) =>
      this.check(this.module._isosplat_core_decode_packed(this.core, at, bytes.length, shapeAt)),
    );
    return new Uint32Array(this.result(0).slice().buffer);
  }

  decodeChunk(shape: ChunkShape & { checksum: number }, bytes: Uint8Array): DecodedChunk {
    const { core, module } = this;
    this.withChunk(shape, bytes, (at, words) =>
      this.check(module._isosplat_core_decode_chunk(core, at, bytes.length, words, shape.checksum)),
    );
    return {
      samples: new Uint32Array(this.result(decodedSamples).slice().buffer),
      clusters: this.result(decodedClusters).slice(),
    };
  }

  /** `samples`: those of the store's chunk, in any order. Returns a PackedField for each. */
  decodeField(
    chunk: ChunkShape & { checksum: number },
    bytes: Uint8Array,
    samples: Uint32Array,
    bits: 8 | 16,
  ): Uint32Array {
    const { core, module } = this;
    const count = samples.length / (packedSampleBytes / 4);
    const { checksum } = chunk;
    this.withChunk(chunk, bytes, (at, shape) =>
      this.withBytes(asBytes(samples), (from) =>
        this.check(
          module._isosplat_core_decode_field(
            ...([core, at, bytes.length, shape, checksum] as const),
            ...([from, count, bits] as const),
          ),
        ),
      ),
    );
    return new Uint32Array(this.result(0).slice().buffer);
  }

  close(): void {
    if (this.#core) this.module._isosplat_core_destroy(this.#core);
    this.#core = 0;
  }
}

export function asBytes(array: Float64Array | Float32Array | Uint32Array): Uint8Array {
  return new Uint8Array(array.buffer, array.byteOffset, array.byteLength);
}

export function copyIn(module: CoreModule, bytes: Uint8Array): number {
  // One byte more, since malloc(0) may return null.
  const at = module._malloc(bytes.length + 1);
  if (at === 0) {
    throw new CoreError("out_of_memory", `no room for ${bytes.length} bytes in the core's memory`);
  }
  module.HEAPU8.set(bytes, at);
  return at;
}
