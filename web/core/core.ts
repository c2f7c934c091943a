import { asBytes, Calls, type ChunkShape, copyIn } from "./calls.ts";
import type { CoreModule } from "./module.ts";
import { type Chunk, type Page, readChunks, readInfo, readPages, readWords } from "./records.ts";
import type { Points, Samples, StoreInfo, Triple } from "./types.ts";

/** What is looked at, for Store.select. */
export interface SelectionView {
  /** World to clip space, 16 numbers, column-major. */
  viewProjection: ArrayLike<number>;
  width: number;
  height: number;
  isovalues: readonly number[];
  loadCellPixels: number;
  drawCellPixels: number;
  cellBudget: number;
  /** Only expected: leaves no trace in what later selections hold on to. */
  ahead?: boolean;
  /** Leaves out what `setVisibility` says is hidden, and waits for it to say so. */
  occlusion?: boolean;
}

/** Words of the regions of one chunk (RegionMask in shared/grid/region_mask.h). */
export const regionWords = 16;
/** Words of one chunk in the answer of an occlusion query: its handle, the regions tested, those seen. */
export const visibilityWords = 1 + 2 * regionWords;

/** What a view needs (Selection in shared/select/selector.h). */
export interface CoreSelection {
  /** Chunks and directory pages to fetch, the most needed first. */
  load: Chunk[];
  pages: number[];
  /** Resident chunks to draw, and `regionWords` for each. */
  drawn: Uint32Array;
  regions: Uint32Array;
  /** Resident chunks that the view needs, drawn yet or not. */
  keep: Uint32Array;
  /** Drawn chunks that stand for finer ones: `setVisibility` is to say what of them may be seen. */
  test: Uint32Array;
  /** Chunks that wait for that. */
  undecided: number;
  finestLevel: number;
  coarsestLevel: number;
  limitedByBudget: boolean;
}

/** The end of the file that holds the coarsest levels, chunks and pages. */
export interface CoarseRange {
  firstLevel: number;
  offset: number;
  bytes: number;
}

/** The core's functions in one WebAssembly instance. Make stores with it, or decode chunks. */
export class Core {
  readonly #module: CoreModule;
  #decoder = 0;

  constructor(module: CoreModule) {
    this.#module = module;
  }

  /** Opens a store from its first min(64 KiB, file size) bytes. Close it to free its memory. */
  openStore(header: Uint8Array): Store {
    const calls = new Calls(this.#module);
    try {
      calls.withBytes(header, (at) =>
        calls.check(this.#module._isosplat_core_open(calls.core, at, header.length)),
      );
      return new Store(this.#module, calls);
    } catch (error) {
      calls.close();
      throw error;
    }
  }

  /** What a chunk's directory entry records of its bytes. */
  checksum(bytes: Uint8Array): number {
    const at = copyIn(this.#module, bytes);
    try {
      return this.#module._isosplat_core_checksum(at, bytes.length) >>> 0;
    } finally {
      this.#module._free(at);
    }
  }

  /** Decodes a chunk for the GPU: PackedSample, four words each. Needs no open store. */
  decodePacked(shape: ChunkShape, bytes: Uint8Array): Uint32Array {
    this.#decoder ||= this.#module._isosplat_core_create();
    const calls = new Calls(this.#module, this.#decoder);
    return calls.decodePacked(shape, bytes);
  }

  /** What the instance has taken from the system so far; it is never given back, but reused. */
  get heapBytes(): number {
    return this.#module.HEAPU8.length;
  }

  /** Frees the decoder. Stores are closed on their own. */
  close(): void {
    if (this.#decoder) this.#module._isosplat_core_destroy(this.#decoder);
    this.#decoder = 0;
  }
}

/** An open store: its directory, as far as it has been added, and what it answers. */
export class Store {
  readonly info: StoreInfo;
  readonly #module: CoreModule;
  readonly #calls: Calls;

  /** @internal */
  constructor(module: CoreModule, calls: Calls) {
    this.#module = module;
    this.#calls = calls;
    calls.check(module._isosplat_core_info(calls.core));
    this.info = readInfo(calls.result(0), calls.result(1), calls.result(2));
  }

  /** The isovalue as the store's quantized values, in single precision. */
  quantizedIsovalue(isovalue: number): number {
    return this.#module._isosplat_core_quantized_isovalue(this.#calls.core, isovalue);
  }

  /** The levels that fit, with their pages, in so many bytes; at least the coarsest one. */
  coarseRange(maxBytes: number): CoarseRange {
    this.#calls.check(this.#module._isosplat_core_coarse_range(this.#calls.core, maxBytes));
    return this.#coarseRange();
  }

  /** What to fetch first, after the header: of it, `firstLevel` and those above are complete. */
  bootstrapRange(): CoarseRange {
    this.#calls.check(this.#module._isosplat_core_bootstrap_range(this.#calls.core));
    return this.#coarseRange();
  }

  #coarseRange(): CoarseRange {
    const [firstLevel = 0, offset = 0, bytes = 0] = new Float64Array(
      this.#calls.result(0).slice().buffer,
    );
    return { firstLevel, offset, bytes };
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

  /** The pages that `chunksFor` of the same arguments still needs. */
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

  decodePacked(shape: ChunkShape, bytes: Uint8Array): Uint32Array {
    return this.#calls.decodePacked(shape, bytes);
  }

  /** Decodes a chunk to samples in the world, as typed arrays that the caller owns. */
  decodeSamples(chunk: ChunkShape & { block: Triple }, bytes: Uint8Array): Samples {
    const calls = this.#calls;
    calls.withChunk(chunk, bytes, (at, shape, block) =>
      calls.check(
        this.#module._isosplat_core_decode_samples(calls.core, at, bytes.length, shape, block),
      ),
    );
    const values = calls.floats(1);
    return {
      count: values.length,
      positions: calls.floats(0),
      values,
      gradients: calls.floats(2),
      intervals: calls.floats(3),
    };
  }

  /**
   * Projects a chunk's active samples onto an isosurface: one point for each, inside of its cell.
   * `exact`: to the trilinear surface along the gradient instead of by one Newton step.
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
    calls.withChunk(chunk, bytes, (at, shape, block) =>
      calls.check(
        this.#module._isosplat_core_project(
          calls.core,
          at,
          bytes.length,
          shape,
          block,
          quantizedIsovalue,
          exact,
        ),
      ),
    );
    return calls.points();
  }

  /**
   * The same of samples as `decodePacked` yields them, for renderers that hold these.
   * `regions`: `regionWords` words; samples in other regions of the block are left out.
   */
  projectPacked(
    place: { level: number; block: Triple },
    samples: Uint32Array,
    isovalue: number,
    options: { exact?: boolean; regions?: Uint32Array } = {},
  ): Points {
    const calls = this.#calls;
    const { regions, exact } = options;
    // One copy: the block, the regions, the samples.
    const words = new Uint32Array(4 + regionWords + samples.length);
    words.set(place.block);
    if (regions) words.set(regions.subarray(0, regionWords), 4);
    words.set(samples, 4 + regionWords);
    calls.withBytes(asBytes(words), (at) =>
      calls.check(
        this.#module._isosplat_core_project_packed(
          calls.core,
          at + 4 * (4 + regionWords),
          samples.length >> 2,
          regions ? at + 16 : 0,
          place.level,
          at,
          this.quantizedIsovalue(isovalue),
          exact ? 1 : 0,
        ),
      ),
    );
    return calls.points();
  }

  /** Which chunks to load and to draw for a view. */
  select(view: SelectionView): CoreSelection {
    const calls = this.#calls;
    const numbers = new Float64Array(23);
    numbers.set(Array.from({ length: 16 }, (_, i) => view.viewProjection[i] ?? 0));
    numbers.set(
      [
        view.width,
        view.height,
        view.loadCellPixels,
        view.drawCellPixels,
        view.cellBudget,
        view.ahead ? 1 : 0,
        view.occlusion ? 1 : 0,
      ],
      16,
    );
    const quantizedIsovalues = Float32Array.from(view.isovalues, (isovalue) =>
      this.quantizedIsovalue(isovalue),
    );
    calls.withBytes(asBytes(numbers), (numbersAt) =>
      calls.withBytes(asBytes(quantizedIsovalues), (quantizedIsovaluesAt) =>
        calls.check(
          this.#module._isosplat_core_select(
            calls.core,
            numbersAt,
            quantizedIsovaluesAt,
            quantizedIsovalues.length,
          ),
        ),
      ),
    );
    const draw = readWords(calls.result(2));
    const count = draw.length / (1 + regionWords);
    const drawn = new Uint32Array(count);
    const regions = new Uint32Array(regionWords * count);
    for (let i = 0; i < count; ++i) {
      const at = i * (1 + regionWords);
      drawn[i] = draw[at] ?? 0;
      regions.set(draw.subarray(at + 1, at + 1 + regionWords), regionWords * i);
    }
    const keep = readWords(calls.result(3));
    const tests = keep[4] ?? 0;
    return {
      load: readChunks(calls.result(0)),
      pages: Array.from(readWords(calls.result(1))),
      drawn,
      regions,
      test: keep.slice(5, 5 + tests),
      keep: keep.slice(5 + tests),
      undecided: keep[3] ?? 0,
      finestLevel: (keep[0] ?? 0) | 0,
      coarsestLevel: (keep[1] ?? 0) | 0,
      limitedByBudget: keep[2] === 1,
    };
  }

  /** The answer of an occlusion query for the view selected last: `visibilityWords` for each chunk. */
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

  /** Says that a chunk has been decoded and may be drawn, or no longer may. */
  setResident(handle: number, resident: boolean): void {
    this.#calls.check(
      this.#module._isosplat_core_set_resident(this.#calls.core, handle, resident ? 1 : 0),
    );
  }

  /** Frees everything. The store must not be used afterwards. */
  close(): void {
    this.#calls.close();
  }
}
