import * as layouts from "../../build/wasm/web/layouts.js";
import { textAt } from "../core/text.ts";
import { faultOfStatus } from "../stream/faults.ts";
import { RendererError } from "./renderer_error.ts";
import type { RendererExports } from "./renderer_program.ts";

/**
 * Size of the largest group of records that one call takes or returns. Bulk data have separate
 * memory.
 */
const scratchBytes = Math.max(
  layouts.volumeBytes,
  layouts.appearanceBytes,
  layouts.lightBytes,
  layouts.frameStatisticsBytes,
  layouts.cameraBytes + layouts.projectionBytes,
  layouts.pickBytes,
  layouts.isosurfaceBytes * layouts.maxIsosurfaces,
  layouts.clipBoxBytes + layouts.planeBytes * layouts.maxClipPlanes,
  layouts.planeBytes * layouts.maxSlices,
);

/**
 * One instance of the renderer's program: its functions, memory for their arguments, and their
 * errors.
 */
export class RendererInstance {
  readonly exports: RendererExports;
  /** Memory for records: `scratchBytes`. */
  readonly scratch: number;
  /** Memory for bulk data. It grows as needed. */
  #bulk = 0;
  #bulkBytes = 0;

  constructor(exports: RendererExports) {
    this.exports = exports;
    this.scratch = exports._malloc(scratchBytes);
  }

  /** Throws a RendererError if a call has failed. */
  check(status: number): void {
    if (status === 0) return;
    const message = textAt(this.exports, this.exports._isosplat_renderer_error());
    const name = textAt(this.exports, this.exports._isosplat_core_status_name(status));
    const isFull = faultOfStatus(name) === "out-of-memory";
    throw new RendererError(message, isFull ? "out-of-memory" : "renderer-failed");
  }

  /** A view of the heap, for the functions of layouts.js. Valid until the next call. */
  view(): DataView {
    return new DataView(this.exports.HEAPU8.buffer);
  }

  /** Memory of at least this size, 8-byte-aligned. It is valid until the next call of this method. */
  reserve(bytes: number): number {
    if (bytes > this.#bulkBytes) {
      this.exports._free(this.#bulk);
      this.#bulkBytes = Math.max(bytes, 1 << 16);
      this.#bulk = this.exports._malloc(this.#bulkBytes);
      if (this.#bulk === 0) {
        this.#bulkBytes = 0;
        const text = `out of memory: ${bytes} bytes for a chunk's samples`;
        throw new RendererError(text, "out-of-memory");
      }
    }
    return this.#bulk;
  }

  /** A zero-terminated text in the memory of the instance, to be freed by the caller. */
  text(text: string): number {
    const bytes = new TextEncoder().encode(`${text}\0`);
    const pointer = this.exports._malloc(bytes.length);
    this.exports.HEAPU8.set(bytes, pointer);
    return pointer;
  }
}
