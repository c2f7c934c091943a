import * as layouts from "../../build/wasm/web/layouts.js";
import {
  type Chunk,
  instantiate,
  type ModuleFactory,
  type StoreInfo,
  volumeRecord,
} from "../core/index.ts";

/** The exports of isosplat-measure.wasm: shared/wasm/measure_api.h. */
interface Exports {
  HEAPU8: Uint8Array;
  _malloc(bytes: number): number;
  _free(at: number): void;
  _isosplat_measure_begin(volume: number, quantizedIsovalue: number, lowest: number): void;
  _isosplat_measure_add(data: number, bytes: number, shape: number, checksum: number): number;
  _isosplat_measure_result(result: number): void;
}

export interface SurfaceExtent {
  /** World units². */
  area: number;
  /** Of the values above the isovalue, world units³; undefined if the volume has missing voxels. */
  volumeAbove?: number;
  /** Of the whole grid, world units³. */
  gridVolume: number;
}

/** What calls `chunk` for every chunk of the finest level that an isovalue needs; false: it is damaged. */
export type ChunkReader = (
  chunk: (chunk: Chunk, bytes: Uint8Array) => Promise<boolean>,
) => Promise<void>;

let compiled: Promise<WebAssembly.Module> | null = null;

function compile(): Promise<WebAssembly.Module> {
  const url = new URL("../../build/wasm/web/isosplat-measure.wasm", import.meta.url);
  compiled ??= fetch(url)
    .then(async (response) => {
      if (!response.ok) throw new Error(`the module for areas: status ${response.status}`);
      return WebAssembly.compile(await response.arrayBuffer());
    })
    .catch((error) => {
      compiled = null; // the next call tries again
      throw error;
    });
  return compiled;
}

/**
 * Area and volume of an isosurface, from its triangles at full detail (shared/mesh/surface_extent.h).
 * Works in pieces of one chunk. Rejects with the reader's reason.
 */
export async function surfaceExtent(
  info: StoreInfo,
  quantizedIsovalue: number,
  read: ChunkReader,
): Promise<SurfaceExtent> {
  const [{ default: factory }, program] = await Promise.all([
    import("../../build/wasm/web/isosplat-measure.js"),
    compile(),
  ]);
  const module = await instantiate<Exports>(factory as ModuleFactory, program);
  const view = () => new DataView(module.HEAPU8.buffer);
  const scratch = module._malloc(Math.max(layouts.volumeBytes, layouts.chunkShapeBytes));
  layouts.writeVolume(view(), scratch, volumeRecord(info));
  module._isosplat_measure_begin(scratch, quantizedIsovalue, info.quantizedRange[0]);
  await read(async (chunk, bytes) => {
    const at = module._malloc(bytes.length);
    module.HEAPU8.set(bytes, at);
    layouts.writeChunkShape(view(), scratch, chunk);
    const status = module._isosplat_measure_add(at, bytes.length, scratch, chunk.checksum);
    module._free(at);
    return status === 0;
  });
  module._isosplat_measure_result(scratch);
  const [area = 0, volumeAbove = 0, gridVolume = 0] = [0, 8, 16].map((offset) =>
    view().getFloat64(scratch + offset, true),
  );
  return { area, gridVolume, ...(!info.mapping.hasMissing && { volumeAbove }) };
}
