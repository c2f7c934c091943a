import type { CoreSelection, SelectionView, Store } from "../core/core.ts";
import type { Chunk } from "../core/records.ts";
import type { DecodedChunk } from "../core/types.ts";
import type { BackgroundLoader } from "./background_loader.ts";
import type { Backoff } from "./backoff.ts";
import type { ChunkQueue } from "./chunk_queue.ts";
import type { ChunkUploads } from "./chunk_uploads.ts";
import type { CoarseLoader } from "./coarse_loader.ts";
import type { Motion } from "./motion.ts";
import type { OcclusionQueries } from "./occlusion_queries.ts";
import type { PageLoader } from "./page_loader.ts";
import { Prefetch } from "./prefetch.ts";
import { sameNumbers } from "./same_numbers.ts";
import type { SourceCheck } from "./source_check.ts";
import type { CameraView, StreamEvents } from "./types.ts";

/**
 * A refined camera view may use this share of the budget that the pinned chunks leave: finer and
 * coarser chunks are both resident while one replaces the other.
 */
const targetShare = 0.75;
/** No cell on a screen is larger than this (pixels). */
const coarsestPixels = 1e6;
/** Bytes prefetched at a time while the isovalue moves. */
const maxPrefetchBytes = 160 * 1024;

/** The parts that the selection loop uses. */
export interface SelectionParts {
  store: Store;
  queue: ChunkQueue<DecodedChunk>;
  pages: PageLoader;
  uploads: ChunkUploads;
  coarse: CoarseLoader;
  background: BackgroundLoader;
  motion: Motion;
  occlusion: OcclusionQueries;
  sourceCheck: SourceCheck;
  backoff: Backoff;
  viewer: StreamEvents;
  /** Whether the chunk can be read without a request. Undefined if no chunk can. */
  isKept: ((chunk: Chunk) => boolean) | undefined;
  /** Sets a mark on the browser's timeline. */
  mark(name: string): void;
}

/** Size in pixels up to which a cell is not refined further: at rest, and while the camera moves. */
export interface CellPixels {
  target: number;
  moving: number;
}

/**
 * Selects for a camera view: shows the resident chunks, requests the missing chunks and pages, and
 * requests occlusion queries.
 */
export class SelectionLoop {
  readonly #parts: SelectionParts;
  readonly #cellPixels: CellPixels;
  readonly #prefetch = new Prefetch();
  #usesOcclusion: boolean;
  #selection: CoreSelection | undefined;
  #visible: Uint32Array = new Uint32Array();
  #regions: Uint32Array = new Uint32Array();
  #isHere = false;

  constructor(parts: SelectionParts, cellPixels: CellPixels) {
    this.#parts = parts;
    this.#cellPixels = cellPixels;
    this.#usesOcclusion = parts.viewer.testOcclusion !== undefined;
  }

  /** The last selection. */
  get selection(): CoreSelection | undefined {
    return this.#selection;
  }

  /** The chunks that are drawn. */
  get drawn(): Uint32Array {
    return this.#visible;
  }

  /** Whether no chunk of the last selection needs a request, so that movement does not delay it. */
  get isHere(): boolean {
    return this.#isHere;
  }

  /**
   * From now on, occluded chunks are fetched like all others. Returns whether occlusion was used
   * before.
   */
  disableOcclusion(): boolean {
    const wasUsed = this.#usesOcclusion;
    this.#usesOcclusion = false;
    return wasUsed;
  }

  /** Throws the errors of the core. */
  run(cameraView: CameraView): void {
    const { uploads, motion, queue, pages } = this.#parts;
    const { view, selection, isHere } = this.#select(cameraView);
    this.#selection = selection;
    this.#isHere = isHere;
    uploads.residency.use(selection.drawn, selection.keep, this.#visible);
    this.#show(selection);
    this.#requestOcclusionQuery(selection, view.occlusion ?? false);
    pages.need(this.#pagesToFetch(selection));
    const needed = selection.load.filter((chunk) => this.#isToBeFetched(chunk));
    if (motion.isovalueMoves && !isHere) {
      const ahead = this.#selectAhead(view);
      queue.need(this.#prefetch.select(needed, queue.underway(), ahead));
    } else {
      this.#prefetch.end();
      queue.need(needed);
    }
  }

  /**
   * Selects all chunks of the view if no request is needed for them (`isHere`), because decoding takes less time
   * than occlusion queries. Otherwise selects only chunks that are not occluded.
   */
  #select(cameraView: CameraView): {
    view: SelectionView;
    selection: CoreSelection;
    isHere: boolean;
  } {
    const { store, isKept } = this.#parts;
    const view = this.#selectionView(cameraView);
    if (isKept && cameraView.stepCellPixels === undefined) {
      const whole = { ...view, occlusion: false };
      const selection = store.select(whole);
      const { limitedByBudget, load, pages } = selection;
      const isHere = !limitedByBudget && pages.length === 0 && load.every(isKept);
      if (isHere) return { view: whole, selection, isHere };
    }
    return { view, selection: store.select(view), isHere: false };
  }

  /** Whether the last selection would be the same with this sample budget. */
  fits(budget: number): boolean {
    const { residency } = this.#parts.uploads;
    if (!this.#selection || this.#selection.limitedByBudget) return false;
    const { keep, load } = this.#selection;
    const cells = load.reduce((sum, chunk) => sum + chunk.cells, residency.samplesOf(keep));
    return cells <= cellBudget(budget, residency.pinnedSamples);
  }

  /** The finest level that a view draws or requests. Fetches nothing. */
  finestLevelOf(cameraView: CameraView): number {
    const { store, pages } = this.#parts;
    const view = this.#selectionView(cameraView);
    const drawCellPixels = view.loadCellPixels;
    const selection = store.select({ ...view, drawCellPixels, ahead: true });
    const levels = [
      ...selection.load.map(({ level }) => level),
      ...selection.pages.map((page) => pages.level(page)),
    ];
    if (selection.finestLevel >= 0) levels.push(selection.finestLevel);
    return levels.length > 0 ? Math.min(...levels) : store.info.levels - 1;
  }

  #selectionView(cameraView: CameraView): SelectionView {
    const { uploads, motion } = this.#parts;
    const { budget, pinnedSamples } = uploads.residency;
    // While something moves, little is fetched, and the result of a query would be out of date.
    const isMoving = motion.cameraMoves || motion.isovalueMoves;
    const isStep = cameraView.stepCellPixels !== undefined;
    const target = Math.min(cameraView.stepCellPixels ?? this.#cellPixels.target, coarsestPixels);
    const moving = Math.max(this.#cellPixels.moving, target);
    return {
      viewProjection: cameraView.viewProjection,
      width: cameraView.viewport.width,
      height: cameraView.viewport.height,
      isovalues: cameraView.isovalues,
      loadCellPixels: motion.cameraMoves ? moving : target,
      drawCellPixels: this.#cellPixels.target,
      cellBudget: cellBudget(budget, pinnedSamples),
      occlusion: this.#usesOcclusion && !isMoving && !isStep,
    };
  }

  #requestOcclusionQuery(selection: CoreSelection, usesOcclusion: boolean): void {
    const { occlusion, viewer, queue, pages, uploads, coarse, backoff } = this.#parts;
    const isPending = ({ handle }: Chunk): boolean =>
      queue.state(handle) !== "failed" && !uploads.isRejected(handle);
    occlusion.need({
      ids: usesOcclusion ? selection.test : undefined,
      isLoading:
        selection.load.some(isPending) || selection.pages.some((page) => !pages.isDamaged(page)),
      isUndecided: selection.undecided > 0,
      // Do not wait for coarse levels that cannot be fetched.
      isTooCoarse: coarse.isLoading && !backoff.trouble,
    });
    if (!occlusion.done) viewer.testOcclusion?.();
  }

  /** The first chunks for the isovalues expected next. Empty if the isovalues move too fast. */
  #selectAhead(view: SelectionView): Chunk[] {
    const { store, motion, pages, background } = this.#parts;
    const [low, high] = store.info.range;
    const isovalues = motion.isovaluesAhead(high - low, background.isPrepared);
    if (!isovalues) return [];
    const loadCellPixels = this.#cellPixels.moving;
    const next = store.select({ ...view, isovalues, loadCellPixels, ahead: true });
    const now = this.#selection ? this.#pagesToFetch(this.#selection) : [];
    pages.need([...now, ...this.#pagesToFetch(next)]);
    const chunks: Chunk[] = [];
    let bytes = 0;
    for (const chunk of next.load) {
      if (!this.#isToBeFetched(chunk)) continue;
      bytes += chunk.bytes;
      if (bytes > maxPrefetchBytes) break;
      chunks.push(chunk);
    }
    return chunks;
  }

  #isToBeFetched({ handle, level }: Chunk): boolean {
    const { background, coarse, sourceCheck, uploads } = this.#parts;
    return (
      coarse.hasFirstSurface &&
      !sourceCheck.isReplaced &&
      !coarse.isLoadingLevel(level) &&
      !background.isArriving(handle) &&
      !uploads.isQueued(handle) &&
      !uploads.isRejected(handle)
    );
  }

  #pagesToFetch(selection: CoreSelection): number[] {
    const { coarse, sourceCheck, pages } = this.#parts;
    if (sourceCheck.isReplaced) return [];
    return selection.pages.filter((page) => !coarse.isLoadingLevel(pages.level(page)));
  }

  #show({ drawn, regions }: CoreSelection): void {
    if (sameNumbers(drawn, this.#visible) && sameNumbers(regions, this.#regions)) return;
    if (this.#visible.length === 0) this.#parts.mark("isosplat:surface");
    this.#parts.occlusion.pictureChanged();
    this.#visible = drawn;
    this.#regions = regions;
    this.#parts.viewer.visible(drawn.slice(), regions.slice());
  }
}

function cellBudget(budget: number, pinnedSamples: number): number {
  return Math.max(0, (budget - pinnedSamples) * targetShare);
}
