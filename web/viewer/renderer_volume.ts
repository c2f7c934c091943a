import * as layouts from "../../build/wasm/web/layouts.js";
import { regionWords } from "../core/core.ts";
import { volumeRecord } from "../core/records.ts";
import type { StoreInfo } from "../core/types.ts";
import type { ChunkPlace } from "../stream/types.ts";
import { colourChannels } from "./colour_channels.ts";
import type { RendererInstance } from "./renderer_instance.ts";
import type { Surface } from "./types.ts";

/** value = offset + scale · quantized value; hasMissing: 65535 marks missing ones. */
export interface FieldMapping {
  offset: number;
  scale: number;
  hasMissing: boolean;
}

const drawnChunkWords = layouts.drawnChunkBytes / 4;

/** One volume that a renderer draws: its grid, its chunks, and its surfaces. */
export class RendererVolume {
  readonly #instance: RendererInstance;
  readonly #number: number;
  /** The renderer's context. Samples are uploaded from JavaScript, without a copy in the heap. */
  readonly #gl: WebGL2RenderingContext;

  /** `number`: of the volume in its renderer. Smaller ones come first. */
  constructor(instance: RendererInstance, gl: WebGL2RenderingContext, number: number) {
    this.#instance = instance;
    this.#number = number;
    this.#gl = gl;
  }

  /** Adds the volume, or replaces it: nothing of it is drawn until chunks are added. */
  open(info: StoreInfo): void {
    const { exports, scratch } = this.#instance;
    layouts.writeVolume(this.#instance.view(), scratch, volumeRecord(info));
    this.#instance.check(exports._isosplat_renderer_set_volume(this.#number, scratch));
  }

  /** Moves the volume and its chunks: sets another grid for the same voxels. */
  move(info: StoreInfo): void {
    const { exports, scratch } = this.#instance;
    layouts.writeVolume(this.#instance.view(), scratch, volumeRecord(info));
    this.#instance.check(exports._isosplat_renderer_move_volume(this.#number, scratch));
  }

  /** Removes the volume, its chunks, and its surfaces. */
  remove(): void {
    this.#instance.exports._isosplat_renderer_remove_volume(this.#number);
  }

  /** samples, clusters: those of a DecodedChunk. */
  addChunk(handle: number, place: ChunkPlace, samples: Uint32Array, clusters: Uint8Array): void {
    const pointer = this.#instance.reserve(clusters.byteLength);
    this.#instance.exports.HEAPU8.set(clusters, pointer);
    layouts.writeBlock(this.#instance.view(), this.#instance.scratch, place);
    const offsetAt = this.#instance.scratch + layouts.blockBytes;
    this.#instance.check(
      this.#instance.exports._isosplat_renderer_reserve_chunk(
        this.#number,
        handle,
        this.#instance.scratch,
        pointer,
        clusters.byteLength,
        offsetAt,
      ),
    );
    if (samples.length === 0) return;
    const offset = this.#instance.view().getFloat64(offsetAt, true);
    this.#gl.bufferSubData(WebGL2RenderingContext.ARRAY_BUFFER, offset, samples);
  }

  /** The samples of a chunk, read back from the GPU, which waits. Throws if it has no such chunk. */
  readSamples(handle: number): Uint32Array {
    const { exports, scratch } = this.#instance;
    this.#instance.check(exports._isosplat_renderer_bind_samples(this.#number, handle, scratch));
    const { offset, count } = layouts.readSampleRange(this.#instance.view(), scratch);
    const samples = new Uint32Array((count * layouts.packedSampleBytes) / 4);
    if (count > 0) {
      this.#gl.getBufferSubData(WebGL2RenderingContext.ARRAY_BUFFER, offset, samples);
    }
    return samples;
  }

  /**
   * Sets the field whose values chunks can have, or none. Chunks lose the values that they have, also of the same
   * field.
   */
  setField(mapping: FieldMapping | null): void {
    const { exports, scratch } = this.#instance;
    if (mapping) {
      layouts.writeFieldMapping(this.#instance.view(), scratch, {
        valueOffset: mapping.offset,
        valueScale: mapping.scale,
        hasMissing: mapping.hasMissing ? 1 : 0,
      });
    }
    this.#instance.check(exports._isosplat_renderer_set_field(this.#number, mapping ? scratch : 0));
  }

  /** Adds the values of the field to a chunk: PackedField, four words for each sample, in their order. */
  addField(handle: number, values: Uint32Array): void {
    const { exports, scratch } = this.#instance;
    const samples = (4 * values.length) / layouts.packedSampleBytes;
    this.#instance.check(
      exports._isosplat_renderer_reserve_chunk_field(this.#number, handle, samples, scratch),
    );
    if (values.length === 0) return;
    const offset = this.#instance.view().getFloat64(scratch, true);
    this.#gl.bufferSubData(WebGL2RenderingContext.ARRAY_BUFFER, offset, values);
  }

  removeChunk(handle: number): void {
    this.#instance.exports._isosplat_renderer_remove_chunk(this.#number, handle);
  }

  /** Sets the chunks to draw from now on. regions: `regionWords` per chunk (RegionMask). */
  setVisible(handles: ArrayLike<number>, regions: ArrayLike<number>): void {
    const count = handles.length;
    const pointer = this.#instance.reserve(count * layouts.drawnChunkBytes);
    const heap = this.#instance.exports.HEAPU32;
    for (let i = 0; i < count; ++i) {
      const at = (pointer >> 2) + i * drawnChunkWords;
      heap[at + layouts.drawnChunkOffsets.handle / 4] = handles[i] ?? 0;
      const regionsAt = at + layouts.drawnChunkOffsets.regions / 4;
      for (let word = 0; word < regionWords; ++word) {
        heap[regionsAt + word] = regions[i * regionWords + word] ?? 0;
      }
    }
    this.#instance.exports._isosplat_renderer_set_visible(this.#number, pointer, count);
  }

  setSurfaces(surfaces: readonly Surface[]): void {
    const used = surfaces.slice(0, layouts.maxIsosurfaces);
    const data = this.#instance.view();
    used.forEach(({ isovalue, colour, opacity }, i) => {
      const record = { isovalue, colour: colourChannels(colour), opacity };
      layouts.writeIsosurface(data, this.#instance.scratch + i * layouts.isosurfaceBytes, record);
    });
    this.#instance.exports._isosplat_renderer_set_isosurfaces(
      this.#number,
      this.#instance.scratch,
      used.length,
    );
  }
}
