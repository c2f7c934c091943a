import type { CoreModule } from "./module.ts";
import type { Chunk } from "./records.ts";
import type { Points, Triple } from "./types.ts";

/** A call into the core failed. `status` is the name in shared/base/status.h. */
export class CoreError extends Error {
  readonly status: string;
  constructor(status: string, message: string) {
    super(`${status}: ${message}`);
    this.name = "CoreError";
    this.status = status;
  }
}

/** What a chunk's decoding needs to know beside its bytes. */
export type ChunkShape = Pick<Chunk, "level" | "blockCells" | "bandBegin" | "bandEnd" | "cells">;

/** Calls with memory: what goes in is freed in `finally`, what comes out is read anew each time. */
export class Calls {
  readonly module: CoreModule;
  core: number;

  constructor(module: CoreModule, core = module._isosplat_core_create()) {
    this.module = module;
    this.core = core;
  }

  check(status: number): void {
    if (status === 0) return;
    throw new CoreError(
      text(this.module, this.module._isosplat_core_status_name(status)),
      text(this.module, this.module._isosplat_core_error(this.core)),
    );
  }

  /** A result buffer, valid until the next call. */
  result(buffer: number): Uint8Array {
    const at = this.module._isosplat_core_result(this.core, buffer);
    const bytes = this.module._isosplat_core_result_bytes(this.core, buffer);
    return this.module.HEAPU8.subarray(at, at + bytes);
  }

  /** A result buffer of floats, copied. */
  floats(buffer: number): Float32Array {
    return new Float32Array(this.result(buffer).slice().buffer);
  }

  /** Of a projection's results. */
  points(): Points {
    const positions = this.floats(0);
    return { count: positions.length / 3, positions, normals: this.floats(1) };
  }

  withBytes(bytes: Uint8Array, use: (at: number) => void): void {
    const at = copyIn(this.module, bytes);
    try {
      use(at);
    } finally {
      this.module._free(at);
    }
  }

  withChunk(
    chunk: ChunkShape & { block?: Triple },
    bytes: Uint8Array,
    use: (at: number, shape: number, block: number) => void,
  ): void {
    const words = Uint32Array.from([
      ...chunk.blockCells,
      chunk.bandBegin,
      chunk.bandEnd,
      chunk.cells,
      chunk.level,
      ...(chunk.block ?? [0, 0, 0]),
    ]);
    this.withBytes(bytes, (at) =>
      this.withBytes(asBytes(words), (shape) => use(at, shape, shape + 28)),
    );
  }

  decodePacked(shape: ChunkShape, bytes: Uint8Array): Uint32Array {
    this.withChunk(shape, bytes, (at, words) =>
      this.check(this.module._isosplat_core_decode_packed(this.core, at, bytes.length, words)),
    );
    return new Uint32Array(this.result(0).slice().buffer);
  }

  close(): void {
    if (this.core) this.module._isosplat_core_destroy(this.core);
    this.core = 0;
  }
}

export function asBytes(array: Float64Array | Float32Array | Uint32Array): Uint8Array {
  return new Uint8Array(array.buffer, array.byteOffset, array.byteLength);
}

export function copyIn(module: CoreModule, bytes: Uint8Array): number {
  // One byte more, so that nothing is asked of malloc(0).
  const at = module._malloc(bytes.length + 1);
  if (at === 0) {
    throw new CoreError("out_of_memory", `no room for ${bytes.length} bytes in the core's memory`);
  }
  module.HEAPU8.set(bytes, at);
  return at;
}

function text(module: CoreModule, at: number): string {
  const end = module.HEAPU8.indexOf(0, at);
  return new TextDecoder().decode(module.HEAPU8.slice(at, end));
}
