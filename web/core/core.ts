import * as layouts from "../../build/wasm/web/layouts.js";
import { asBytes, Calls, type ChunkShape, CoreError, copyIn } from "./calls.ts";
import type { CoreModule } from "./module.ts";
import {
  type Chunk,
  type Page,
  readChunks,
  readInfo,
  readPages,
  readWords,
  recordOf,
  viewOf,
} from "./records.ts";
import type { DecodedChunk, Points, Samples, StoreInfo, Triple } from "./types.ts";

/** A camera view, for Store.select. */
export interface SelectionView {
  /** World to clip space: a matrix of 4 × 4, column by column. */
  viewProjection: ArrayLike<number>;
  width: number;
  height: number;
  isovalues: readonly number[];
  loadCellPixels: number;
  drawCellPixels: number;
  cellBudget: number;
  /** The view is only a prediction: later selections do not depend on it. */
  ahead?: boolean;
  /**
   * Leaves out chunks that are hidden according to `setVisibility`, and requests occlusion queries
   * (`test`).
   */
  occlusion?: boolean;
}

/** The largest size of a store's header. */
export const maxHeaderBytes: number = layouts.maxHeaderBytes;
/** Words of the regions of one chunk (RegionMask in shared/core/grid/region_mask.h). */
export const regionWords: number = layouts.regionWords;
/** Words of one chunk in the result of an occlusion query (IsosplatVisibility). */
export const visibilityWords: number = layouts.visibilityBytes / 4;
/** Words of one packed sample. */
export const packedSampleWords: number = layouts.packedSampleBytes / 4;

/** The chunks and pages that a camera view needs (Selection in shared/core/select/selector.h). */
export interface CoreSelection {
  /** Chunks and directory pages to fetch, the most needed first. */
  load: Chunk[];
  pages: number[];
  /** Resident chunks to draw, and `regionWords` for each. */
  drawn: Uint32Array;
  regions: Uint32Array;
  /** Resident chunks that the view needs, drawn yet or not. */
  keep: Uint32Array;
  /** Chunks drawn in place of finer ones. `setVisibility` needs a result for each of them. */
  test: Uint32Array;
  /** The number of chunks that wait for these results. */
  undecided: number;
  finestLevel: number;
  coarsestLevel: number;
  limitedByBudget: boolean;
}

/** Separates the handles of IsosplatDrawnChunk from the regions. */
function readDrawn(words: Uint32Array): Pick<CoreSelection, "drawn" | "regions"> {
  const stride = layouts.drawnChunkBytes / 4;
  const [handle, first] = [
    layouts.drawnChunkOffsets.handle / 4,
    layouts.drawnChunkOffsets.regions / 4,
  ];
  const drawn = new Uint32Array(words.length / stride);
  const regions = new Uint32Array(regionWords * drawn.length);
  for (let i = 0; i < drawn.length; ++i) {
    const at = i * stride;
    drawn[i] = words[at + handle] ?? 0;
    regions.set(words.subarray(at + first, at + first + regionWords), regionWords * i);
  }
  return { drawn, regions };
}

/** The byte range of the file that contains the chunks and pages of the coarsest levels. */
export interface CoarseRange {
  firstLevel: number;
  offset: number;
  bytes: number;
}

/** One WebAssembly instance of the core. It opens stores and decodes chunks. */
export class Core {
  readonly #module: CoreModule;
  #decoder = 0;

  constructor(module: CoreModule) {
    this.#module = module;
  }

  /** Opens a store from its first min(`maxHeaderBytes`, file size) bytes. Close it to free its memory. */
  openStore(header: Uint8Array): Store {
    return this.#open(header, this.#module._isosplat_core_open);
  }

  /** Opens a field of a store from its first bytes. Its directory is read like that of a store. */
  openField(header: Uint8Array): Store {
    return this.#open(header, this.#module._isosplat_core_open_field);
  }

  #open(header: Uint8Array, open: CoreModule["_isosplat_core_open"]): Store {
    const calls = new Calls(this.#module);
    try {
      calls.withBytes(header, (at) => calls.check(open(calls.core, at, header.length)));
      return new Store(this.#module, calls);
    } catch (error) {
      calls.close();
      throw error;
    }
  }

  /**
   * Checks the header of a bundle (shared/core/scene/BUNDLE.md), which begins with these bytes. Throws a
   * CoreError: `truncated` if `bytes` does not contain the whole header; also not_a_store, malformed_header, ….
   */
  checkBundle(bytes: Uint8Array): void {
    this.#decoder ||= this.#module._isosplat_core_create();
    const calls = new Calls(this.#module, this.#decoder);
    calls.withBytes(bytes, (at) =>
      calls.check(this.#module._isosplat_core_check_bundle(calls.core, at, bytes.length)),
    );
  }

  /** The checksum of a chunk's bytes, in the form stored in the directory. */
  checksum(bytes: Uint8Array): number {
    const at = copyIn(this.#module, bytes);
    try {
      return this.#module._isosplat_core_checksum(at, bytes.length) >>> 0;
    } finally {
      this.#module._free(at);
    }
  }

  /** Decodes a chunk for the GPU: `packedSampleWords` for each sample. Needs no open store. */
  decodePacked(shape: ChunkShape, bytes: Uint8Array): Uint32Array {
    this.#decoder ||= this.#module._isosplat_core_create();
    const calls = new Calls(this.#module, this.#decoder);
    return calls.decodePacked(shape, bytes);
  }

  /**
   * Checks and decodes a chunk for the renderer. Needs no open store. Throws a CoreError
   * (checksum_mismatch, malformed_chunk, …).
   */
  decodeChunk(shape: ChunkShape & { checksum: number }, bytes: Uint8Array): DecodedChunk {
    this.#decoder ||= this.#module._isosplat_core_create();
    const calls = new Calls(this.#module, this.#decoder);
    return calls.decodeChunk(shape, bytes);
  }

  /**
   * Checks and decodes a field chunk. `samples`: all samples of the store's chunk (`decodeChunk`). `bits`: of the
   * field's mapping. Returns a PackedField (shared/core/sampling/packed_field.h) of four words for each sample.
   */
  decodeField(
    shape: ChunkShape & { checksum: number },
    bytes: Uint8Array,
    samples: Uint32Array,
    bits: 8 | 16,
  ): Uint32Array {
    this.#decoder ||= this.#module._isosplat_core_create();
    const calls = new Calls(this.#module, this.#decoder);
    return calls.decodeField(shape, bytes, samples, bits);
  }

  /** The size of the instance's memory. It never shrinks; freed memory is used again. */
  get heapBytes(): number {
    return this.#module.HEAPU8.length;
  }

  /** Frees the decoder. It does not close stores. */
  close(): void {
    if (this.#decoder) this.#module._isosplat_core_destroy(this.#decoder);
    this.#decoder = 0;
  }
}

/** An open store, with the pages of its directory that have been added. */
export class Store {
  readonly #module: CoreModule;
  readonly #calls: Calls;
  #info: StoreInfo;

  /** @internal */
  constructor(module: CoreModule, calls: Calls) {
    this.#module = module;
    this.#calls = calls;
    this.#info = readInfoOf(module, calls);
  }

  get info(): StoreInfo {
    return this.#info;
  }

  /**
   * Replaces the distances between voxels, for a volume whose file stated none. Call it before the store is used.
   * Throws a CoreError unless all three are above 0.
   */
  setSpacing([x, y, z]: Triple): void {
    const calls = this.#calls;
    calls.check(this.#module._isosplat_core_set_spacing(calls.core, x, y, z));
    const { statedSpacing = this.#info.spacing } = this.#info;
    this.#info = { ...readInfoOf(this.#module, calls), isSpacingGiven: true, statedSpacing };
  }

  /** The isovalue on the scale of the quantized values, in single precision. */
  quantizedIsovalue(isovalue: number): number {
    const calls = this.#calls;
    calls.check(this.#module._isosplat_core_quantized_isovalue(calls.core, isovalue));
    return viewOf(calls.result(0)).getFloat32(0, true);
  }

  /** The coarsest levels whose chunks and pages fit into `maxBytes`; at least the coarsest one. */
  coarseRange(maxBytes: number): CoarseRange {
    this.#calls.check(this.#module._isosplat_core_coarse_range(this.#calls.core, maxBytes));
    return this.#coarseRange();
  }

  /** The bytes to fetch after the header. They hold `firstLevel` and all coarser levels completely. */
  bootstrapRange(): CoarseRange {
    this.#calls.check(this.#module._isosplat_core_bootstrap_range(this.#calls.core));
    return this.#coarseRange();
  }

  #coarseRange(): CoarseRange {
    return layouts.readCoarseRange(viewOf(this.#calls.result(0)), 0);
  }

  pages(): Page[] {
    this.#calls.check(this.#module._isosplat_core_pages(this.#calls.core));
    return readPages(this.#calls.result(0));
  }

  addPage(page: number, bytes: Uint8Array): void {
    this.#calls.withBytes(bytes, (at) =>
      this.#calls.check(
        this.#module._isosplat_core_add_page(this.#calls.core, page, at, bytes.length),
      ),
    );
  }

  /** The pages that `chunksFor` needs for the same arguments and that are not resident. */
  missingPages(level: number, low: number, high = low): number[] {
    const [from, to] = [this.quantizedIsovalue(low), this.quantizedIsovalue(high)];
    this.#calls.check(this.#module._isosplat_core_missing_pages(this.#calls.core, level, from, to));
    return Array.from(readWords(this.#calls.result(0)));
  }

  /**
   * The chunks of a level that hold every active cell of an isovalue, or of all isovalues from
   * `low` to `high`, in file order.
   */
  chunksFor(level: number, low: number, high = low): Chunk[] {
    const [from, to] = [this.quantizedIsovalue(low), this.quantizedIsovalue(high)];
    this.#calls.check(this.#module._isosplat_core_chunks_for(this.#calls.core, level, from, to));
    return readChunks(this.#calls.result(0));
  }

  /** A chunk by its place, or the number of the directory page that is missing. */
  chunkAt({ level, block, band }: Pick<Chunk, "level" | "block" | "band">): Chunk | number {
    const calls = this.#calls;
    try {
      calls.withBytes(asBytes(Uint32Array.from(block)), (at) =>
        calls.check(this.#module._isosplat_core_chunk_at(calls.core, level, at, band)),
      );
    } catch (error) {
      if (!(error instanceof CoreError) || error.status !== "page_not_resident") throw error;
      return readWords(calls.result(0))[0] ?? 0;
    }
    return layouts.readChunk(viewOf(calls.result(0)), 0);
  }

  decodePacked(shape: ChunkShape, bytes: Uint8Array): Uint32Array {
    return this.#calls.decodePacked(shape, bytes);
  }

  /** Decodes a chunk to samples in world coordinates, as typed arrays that the caller owns. */
  decodeSamples(chunk: ChunkShape & { block: Triple }, bytes: Uint8Array): Samples {
    const calls = this.#calls;
    calls.withChunk(chunk, bytes, (at, shape) =>
      calls.check(this.#module._isosplat_core_decode_samples(calls.core, at, bytes.length, shape)),
    );
    const values = calls.floats(layouts.samplesValues);
    return {
      count: values.length,
      positions: calls.floats(layouts.samplesPositions),
      values,
      gradients: calls.floats(layouts.samplesGradients),
      intervals: calls.floats(layouts.samplesIntervals),
    };
  }

  /**
   * Projects the active samples of a chunk onto an isosurface. Each yields one point inside its cell.
   * `exact`: projects along the gradient to the trilinear surface, instead of by one Newton step.
   */
  project(
    chunk: ChunkShape & { block: Triple },
    bytes: Uint8Array,
    isovalue: number,
    options: { exact?: boolean } = {},
  ): Points {
    const calls = this.#calls;
    const quantizedIsovalue = this.quantizedIsovalue(isovalue);
    const exact = options.exact ? 1 : 0;
    calls.withChunk(chunk, bytes, (at, shape) =>
      calls.check(
        this.#module._isosplat_core_project(
          calls.core,
          at,
          bytes.length,
          shape,
          quantizedIsovalue,
          exact,
        ),
      ),
    );
    return calls.points();
  }

  /**
   * Projects packed samples, as `decodePacked` returns them. `regions`: `regionWords` words; samples
   * in other regions of the block are left out.
   */
  projectPacked(
    place: { level: number; block: Triple },
    samples: Uint32Array,
    isovalue: number,
    options: { exact?: boolean; regions?: Uint32Array } = {},
  ): Points {
    const calls = this.#calls;
    const { regions, exact } = options;
    // Copies the samples, the block and the regions in one piece.
    const block = recordOf(layouts.blockBytes, layouts.writeBlock, place);
    const blockAt = samples.byteLength;
    const regionsAt = blockAt + block.length;
    const bytes = new Uint8Array(regionsAt + 4 * regionWords);
    bytes.set(asBytes(samples));
    bytes.set(block, blockAt);
    if (regions) bytes.set(asBytes(regions.subarray(0, regionWords)), regionsAt);
    calls.withBytes(bytes, (at) =>
      calls.check(
        this.#module._isosplat_core_project_packed(
          calls.core,
          at,
          samples.length / packedSampleWords,
          regions ? at + regionsAt : 0,
          at + blockAt,
          this.quantizedIsovalue(isovalue),
          exact ? 1 : 0,
        ),
      ),
    );
    return calls.points();
  }

  /** Selects the chunks to load and to draw for a camera view. */
  select(view: SelectionView): CoreSelection {
    const calls = this.#calls;
    const record = recordOf(layouts.selectionViewBytes, layouts.writeSelectionView, {
      viewProjection: Array.from(view.viewProjection),
      widthPx: view.width,
      heightPx: view.height,
      loadCellPx: view.loadCellPixels,
      drawCellPx: view.drawCellPixels,
      cellBudget: view.cellBudget,
      ahead: view.ahead ? 1 : 0,
      occlusion: view.occlusion ? 1 : 0,
    });
    const isovalues = Float32Array.from(view.isovalues, (isovalue) =>
      this.quantizedIsovalue(isovalue),
    );
    calls.withBytes(record, (at) =>
      calls.withBytes(asBytes(isovalues), (isovaluesAt) =>
        calls.check(
          this.#module._isosplat_core_select(calls.core, at, isovaluesAt, isovalues.length),
        ),
      ),
    );
    const header = layouts.readSelectionHeader(viewOf(calls.result(layouts.selectionHeader)), 0);
    return {
      load: readChunks(calls.result(layouts.selectionLoad)),
      pages: Array.from(readWords(calls.result(layouts.selectionPages))),
      ...readDrawn(readWords(calls.result(layouts.selectionDraw))),
      test: readWords(calls.result(layouts.selectionTest)).slice(),
      keep: readWords(calls.result(layouts.selectionKeep)).slice(),
      undecided: header.undecided,
      finestLevel: header.finestLevel,
      coarsestLevel: header.coarsestLevel,
      limitedByBudget: header.limitedByBudget !== 0,
    };
  }

  /** Sets the result of an occlusion query for the last selected view: `visibilityWords` per chunk. */
  setVisibility(answers: Uint32Array): void {
    const calls = this.#calls;
    calls.withBytes(asBytes(answers), (at) =>
      calls.check(
        this.#module._isosplat_core_set_visibility(
          calls.core,
          at,
          answers.length / visibilityWords,
        ),
      ),
    );
  }

  /** Sets whether a chunk is resident, so that it may be drawn. */
  setResident(handle: number, resident: boolean): void {
    this.#calls.check(
      this.#module._isosplat_core_set_resident(this.#calls.core, handle, resident ? 1 : 0),
    );
  }

  /** Frees the memory of the store, which cannot be used afterwards. */
  close(): void {
    this.#calls.close();
  }
}

function readInfoOf(module: CoreModule, calls: Calls): StoreInfo {
  calls.check(module._isosplat_core_info(calls.core));
  return readInfo(
    calls.result(layouts.infoRecord),
    calls.result(layouts.infoMetadata),
    calls.result(layouts.infoFields),
  );
}
