import type { Core, Points, Store } from "../core/index.ts";
import { BackgroundLoader, defaultBackgroundBytes, savesData } from "./background_loader.ts";
import { Backoff } from "./backoff.ts";
import { ChunkQueue } from "./chunk_queue.ts";
import { ChunkUploads } from "./chunk_uploads.ts";
import { CoalescedTask } from "./coalesced_task.ts";
import { CoarseLoader } from "./coarse_loader.ts";
import type { Decoder } from "./decoder.ts";
import { defaultSampleBudget } from "./device.ts";
import { Motion } from "./motion.ts";
import { OcclusionQueries, type OcclusionQuery } from "./occlusion_queries.ts";
import { openStore } from "./open_store.ts";
import { PageLoader } from "./page_loader.ts";
import { progressOf } from "./progress.ts";
import { markTimeline, ProgressReporter } from "./progress_reporter.ts";
import { SelectionLoop } from "./selection_loop.ts";
import type { Source } from "./source.ts";
import { SourceCheck } from "./source_check.ts";
import { measured } from "./timeline.ts";
import {
  type CameraView,
  type ChunkPlace,
  type StoreInfo,
  StreamError,
  type StreamEvents,
  type StreamOptions,
} from "./types.ts";
import { WorkerPool } from "./worker_pool.ts";

type SessionOptions = StreamOptions & { decoder?: Decoder };

/** An open store and its source. `closed`: aborts all reads that are still running. */
export interface StoreAccess {
  source: Source;
  store: Store;
  backoff: Backoff;
  closed: AbortSignal;
}

/** One open volume: fetches, decodes and keeps what the camera view needs. See README.md. */
export class StreamSession {
  readonly info: StoreInfo;
  readonly source: Source;
  readonly #store: Store;
  readonly #events: StreamEvents;
  readonly #decoder: Decoder;
  readonly #ownsDecoder: boolean;
  readonly #backoff: Backoff;
  readonly #queue: ChunkQueue;
  readonly #pages: PageLoader;
  readonly #uploads: ChunkUploads;
  readonly #coarse: CoarseLoader;
  readonly #background: BackgroundLoader;
  readonly #sourceCheck: SourceCheck;
  readonly #selectionLoop: SelectionLoop;
  readonly #progress: ProgressReporter;
  readonly #motion = new Motion(() => this.#select());
  readonly #occlusion = new OcclusionQueries();
  readonly #closing = new AbortController();
  /** For changes of the resident chunks. A change of the camera view selects at once. */
  readonly #selecting = new CoalescedTask(() => this.#select());
  #cameraView: CameraView | undefined;

  private constructor(source: Source, store: Store, backoff: Backoff, options: SessionOptions) {
    this.source = source;
    this.info = store.info;
    this.#store = store;
    this.#events = options.events;
    this.#ownsDecoder = !options.decoder;
    this.#decoder = options.decoder ?? new WorkerPool();
    this.#backoff = backoff;
    const { signal } = this.#closing;
    this.#sourceCheck = new SourceCheck(source, this.info, backoff, signal, (error) =>
      this.#events.replaced(error),
    );
    const budget = options.sampleBudget ?? defaultSampleBudget();
    this.#uploads = new ChunkUploads(store, budget, this.#events, {
      changed: () => this.#selecting.request(),
      uploadedInAdvance: () => this.#onAdvance(),
      overflowed: (error) => this.#report(error),
    });
    this.#queue = this.#makeQueue();
    this.#pages = new PageLoader(source, store, backoff, signal, {
      added: () => this.#selecting.request(),
      failed: (error, isFirst) => this.#onPartFailed(error, isFirst),
    });
    this.#coarse = this.#makeCoarseLoader();
    this.#background = this.#makeBackgroundLoader(options.backgroundBytes);
    this.#selectionLoop = this.#makeSelectionLoop(options);
    this.#progress = new ProgressReporter(
      () => this.#currentProgress(),
      (progress) => this.#events.progress(progress),
      (name) => this.#mark(name),
    );
  }

  get isClosed(): boolean {
    return this.#closing.signal.aborted;
  }

  /** Reads the store's header and starts to fetch the coarse levels. Rejects with a StreamError. */
  static async open(source: Source, core: Core, options: SessionOptions): Promise<StreamSession> {
    const signal = options.signal ?? new AbortController().signal;
    let session: StreamSession | undefined;
    const backoff = new Backoff({
      trouble: (error) => {
        if (session) session.#onSourceFault(error);
        else if (error) options.events.error(error);
      },
      slow: (error) => {
        if (session) void session.#sourceCheck.run(error);
      },
    });
    try {
      const store = await openStore(source, core, backoff, signal);
      signal.throwIfAborted();
      session = new StreamSession(source, store, backoff, options);
      const opened = session;
      signal.addEventListener("abort", () => opened.close(), { once: true });
      session.#loadCoarse(options.firstIsovalues);
      return session;
    } catch (error) {
      backoff.close();
      throw error;
    }
  }

  /** Sets the camera view. Cheap if nothing has changed. Call it at most once per frame. */
  update(cameraView: CameraView): void {
    if (this.isClosed) return;
    if (!this.#motion.changed(cameraView)) return;
    this.#occlusion.viewChanged();
    this.#background.stop();
    this.#cameraView = {
      ...cameraView,
      viewProjection: Array.from(cameraView.viewProjection),
      isovalues: [...cameraView.isovalues],
    };
    this.#select();
  }

  /**
   * Projects samples, as `StreamEvents.samples` hands them over, onto an isosurface: for renderers
   * that draw points. `regions`: their chunk's 16 words of `StreamEvents.visible`; default: all.
   */
  project(
    place: ChunkPlace,
    samples: Uint32Array,
    isovalue: number,
    options: { exact?: boolean; regions?: Uint32Array } = {},
  ): Points {
    return this.#store.projectPacked(place, samples, isovalue, options);
  }

  /**
   * The bytes of all chunks of the volume's finest level that an isovalue needs, from any view.
   * Undefined if the directory of these chunks has not been fetched.
   */
  bytesOf(isovalue: number): number | undefined {
    if (this.isClosed || this.#store.missingPages(0, isovalue).length > 0) return undefined;
    return this.#store.chunksFor(0, isovalue).reduce((sum, { bytes }) => sum + bytes, 0);
  }

  /** For other readers of the store than the view: web/mesh. */
  get access(): StoreAccess {
    const closed = this.#closing.signal;
    return { source: this.source, store: this.#store, backoff: this.#backoff, closed };
  }

  /** ValueMapping::quantized_isovalue. */
  quantizedIsovalue(isovalue: number): number {
    return this.#store.quantizedIsovalue(isovalue);
  }

  /** Opacity or clipping has changed, and with it the occlusion. */
  sceneChanged(): void {
    this.#occlusion.viewChanged();
    this.#updateProgress();
  }

  /**
   * The occlusion query that is needed for the picture as it is drawn now, or undefined: see
   * `StreamEvents.testOcclusion`. `settled`: the picture would be the same at rest.
   */
  occlusionQuery(settled: boolean): OcclusionQuery | undefined {
    return this.isClosed ? undefined : this.#occlusion.query(settled);
  }

  /**
   * Whether everything visible is resident according to fast pictures, so that only a query of the
   * resting picture is missing for the view to be complete.
   */
  get needsRestingPicture(): boolean {
    return !this.isClosed && this.#occlusion.needsRest;
  }

  /** `answers`: the result of the query, `visibilityWords` (core) for each drawn chunk. */
  answerOcclusion(query: OcclusionQuery, answers: Uint32Array, settled: boolean): void {
    if (this.isClosed) return;
    measured("isosplat:streaming", () => {
      if (this.#occlusion.record(query, settled)) this.#store.setVisibility(answers);
    });
    this.#selecting.request();
  }

  /** Occlusion queries do not work. From now on, occluded chunks are fetched as well. */
  occlusionFailed(): void {
    this.#selectionLoop.disableOcclusion();
    this.#select();
  }

  /**
   * Retries at once all requests that wait for their next attempt, all damaged parts, and all chunks
   * that did not fit into memory.
   */
  retry(): void {
    if (this.isClosed) return;
    this.#uploads.retry();
    this.#backoff.wake();
    this.#selecting.request();
    this.#retryParts();
  }

  /** Changes `StreamOptions.sampleBudget`. Memory above it is freed when coarser chunks are drawn. */
  setSampleBudget(samples: number): void {
    if (this.isClosed) return;
    this.#uploads.residency.setBudget(samples);
    this.#select();
  }

  /** The viewer accepted these chunks (`samples`), but they did not fit into GPU memory. */
  rejectUploads(ids: readonly number[], message: string): void {
    if (this.isClosed) return;
    const lost = this.#uploads.reject(ids, message);
    // A chunk is dropped only after it has left the picture.
    this.#select();
    for (const id of lost) this.#events.drop(id);
  }

  /** Cancels all requests, drops every chunk (`drop`), and frees all memory. No event follows. */
  close(): void {
    if (this.isClosed) return;
    this.#closing.abort(new DOMException("the volume was closed", "AbortError"));
    this.#motion.close();
    this.#selecting.cancel();
    this.#progress.close();
    this.#queue.close();
    this.#pages.close();
    this.#background.close();
    this.#uploads.close();
    this.#backoff.close();
    if (this.#ownsDecoder) this.#decoder.close();
    try {
      this.#uploads.residency.dropAll();
      this.#store.close();
    } catch (error) {
      // The memory of an aborted instance is freed with the instance.
      if (!(error instanceof WebAssembly.RuntimeError)) throw error;
    }
  }

  #makeQueue(): ChunkQueue {
    const { residency } = this.#uploads;
    return new ChunkQueue(this.source, this.#decoder, this.#backoff, {
      admit: (chunk) => residency.reserve(chunk),
      decoded: (chunk, decoded) => this.#uploads.add(chunk, decoded, "view"),
      released: (chunk) => residency.release(chunk.handle),
      failed: (error, isFirst) => this.#onPartFailed(error, isFirst),
      changed: () => this.#updateProgress(),
    });
  }

  #makeCoarseLoader(): CoarseLoader {
    return new CoarseLoader(this.source, this.#store, this.#backoff, this.#decoder, {
      isResident: (handle) => this.#uploads.residency.has(handle),
      decoded: (chunk, decoded) => this.#uploads.add(chunk, decoded, "coarse"),
      uploaded: () => this.#uploads.drained("coarse"),
      changed: () => this.#selecting.request(),
      failed: (error) => this.#report(error),
    });
  }

  #makeBackgroundLoader(budget = defaultBackgroundBytes(this.info.fileBytes)): BackgroundLoader {
    const { residency } = this.#uploads;
    const bytes = savesData() ? 0 : budget;
    return new BackgroundLoader(this.source, this.#store, this.#decoder, bytes, {
      isResident: (handle) => residency.has(handle) || this.#uploads.isQueued(handle),
      admit: (chunk) => residency.reserveFree(chunk),
      released: (chunk) => residency.release(chunk.handle),
      decoded: (chunk, decoded) => this.#uploads.add(chunk, decoded, "advance"),
      uploaded: () => this.#uploads.drained("advance"),
      changed: () => this.#onAdvance(),
      ended: () => this.#mark("isosplat:prepared"),
    });
  }

  /** Chunks that no view needed when they were fetched do not change a complete picture. */
  #onAdvance(): void {
    if (this.isClosed) return;
    if (this.#isComplete) this.#updateProgress();
    else this.#selecting.request();
  }

  #makeSelectionLoop({ targetCellPixels = 1, movingCellPixels = 5 }: SessionOptions) {
    return new SelectionLoop(
      {
        store: this.#store,
        queue: this.#queue,
        pages: this.#pages,
        uploads: this.#uploads,
        coarse: this.#coarse,
        background: this.#background,
        motion: this.#motion,
        occlusion: this.#occlusion,
        sourceCheck: this.#sourceCheck,
        backoff: this.#backoff,
        viewer: this.#events,
        mark: (name) => this.#mark(name),
      },
      { target: targetCellPixels, moving: movingCellPixels },
    );
  }

  #loadCoarse(firstIsovalues: readonly number[] | undefined): void {
    const suggested = (this.info.metadata.suggested_isovalues ?? []).slice(0, 1);
    const { budget } = this.#uploads.residency;
    void this.#coarse.load(budget, firstIsovalues ?? suggested, this.#closing.signal);
  }

  #select(): void {
    const cameraView = this.#cameraView;
    this.#selecting.cancel();
    if (!cameraView || this.isClosed) return;
    measured("isosplat:streaming", () => {
      try {
        this.#selectionLoop.run(cameraView);
      } catch (error) {
        this.#report(new StreamError("internal", `selection: ${String(error)}`, error));
      }
      this.#updateProgress();
    });
  }

  /** The source keeps failing (`error`), or works again (undefined). */
  #onSourceFault(error: StreamError | undefined): void {
    if (this.isClosed) return;
    if (!error) this.#retryParts();
    // `replaced` has a separate event.
    else if (error.kind === "replaced") this.#updateProgress();
    else this.#report(error);
  }

  #retryParts(): void {
    this.#queue.retry();
    this.#pages.retry();
    this.#updateProgress();
  }

  #onPartFailed(error: StreamError, isFirst: boolean): void {
    // Occlusion queries that waited for this part continue without it.
    this.#selecting.request();
    if (isFirst) this.#report(error);
    void this.#sourceCheck.run(error);
  }

  #report(error: StreamError): void {
    this.#events.error(error);
    this.#updateProgress();
  }

  #updateProgress(): void {
    if (this.isClosed) return;
    this.#prepareOtherIsovalues();
    this.#progress.update();
  }

  get #isComplete(): boolean {
    return this.#currentProgress().state === "complete";
  }

  /** Chunks that the view needs come before chunks that a later view may need. */
  #prepareOtherIsovalues(): void {
    const isovalues = this.#cameraView?.isovalues;
    const isFailing =
      this.#sourceCheck.isReplaced || this.#backoff.trouble || this.#uploads.overflow;
    if (!isovalues || isFailing || !this.#isComplete) this.#background.stop();
    else this.#background.start(isovalues, this.#coarse.finestLevel);
  }

  #currentProgress() {
    return progressOf({
      source: this.source,
      queue: this.#queue,
      pages: this.#pages,
      uploads: this.#uploads,
      motion: this.#motion,
      occlusion: this.#occlusion,
      selection: this.#selectionLoop.selection,
      isSelectionPending: this.#selecting.isRequested,
      isLoadingCoarse: this.#coarse.isLoading,
      preparation: this.#background.preparation,
      sourceFault: this.#backoff.trouble,
    });
  }

  #mark(name: string): void {
    markTimeline(name, this.source, this.#uploads.residency);
  }
}
