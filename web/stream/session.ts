import type { Core, Store } from "../core/core.ts";
import type { Bins, FieldInfo, Points, StoreInfo, StoreMetadata } from "../core/types.ts";
import { Backoff } from "./backoff.ts";
import { CoalescedTask } from "./coalesced_task.ts";
import type { Decoder } from "./decoder.ts";
import { type LevelCost, levelCosts } from "./level_cost.ts";
import type { OcclusionQuery } from "./occlusion_queries.ts";
import { openStore } from "./open_store.ts";
import { progressOf } from "./progress.ts";
import { markTimeline, ProgressReporter } from "./progress_reporter.ts";
import { keptSource } from "./read_ahead.ts";
import {
  makeSessionParts,
  type SessionOptions,
  type SessionParts,
  type StoreAccess,
} from "./session_parts.ts";
import type { Source } from "./source.ts";
import { measured } from "./timeline.ts";
import { type CameraView, type ChunkPlace, StreamError, type StreamEvents } from "./types.ts";
import { WorkerPool } from "./worker_pool.ts";

/** A field that is shown, and its description of itself, which is empty until the field is open. */
export interface ShownField {
  info: FieldInfo;
  metadata: StoreMetadata;
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
  readonly #parts: SessionParts;
  readonly #progress: ProgressReporter;
  readonly #closing = new AbortController();
  #sampleBudget: number;
  /** As `#closing.signal.aborted`, which is slow if it is read for each of many layers. */
  #isClosed = false;
  /** Selects after changes of the resident chunks. A change of the camera view selects at once. */
  readonly #selecting = new CoalescedTask(() => this.#select());

  private constructor(
    core: Core,
    source: Source,
    store: Store,
    backoff: Backoff,
    options: SessionOptions,
  ) {
    this.source = source;
    this.info = store.info;
    this.#store = store;
    this.#events = options.events;
    this.#ownsDecoder = !options.decoder;
    this.#decoder = options.decoder ?? new WorkerPool();
    this.#backoff = backoff;
    this.#parts = makeSessionParts(core, this.access, this.#decoder, options, {
      changed: () => this.#selecting.request(),
      advanced: () => this.#onAdvance(),
      rested: () => this.#select(),
      progressChanged: () => this.#updateProgress(),
      partFailed: (error, isFirst) => this.#onPartFailed(error, isFirst),
      failed: (error) => this.#report(error),
      mark: (name) => this.#mark(name),
    });
    this.#sampleBudget = this.#parts.uploads.residency.budget;
    this.#progress = new ProgressReporter(
      () => this.#currentProgress(),
      (progress) => this.#events.progress(progress),
      (name) => this.#mark(name),
    );
  }

  get isClosed(): boolean {
    return this.#isClosed;
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
        if (session) void session.#parts.sourceCheck.run(error);
      },
    });
    try {
      const store = await openStore(source, (header) => core.openStore(header), backoff, signal);
      signal.throwIfAborted();
      const kept = keptSource(source, store, options.readAheadBytes);
      session = new StreamSession(core, kept, store, backoff, options);
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
    if (!this.#parts.motion.changed(cameraView)) return;
    this.#parts.occlusion.viewChanged();
    this.#stopReadingAhead();
    this.#select();
  }

  /**
   * Projects the samples of `StreamEvents.samples` onto an isosurface, for renderers that draw points.
   * `regions`: the chunk's 16 words of `StreamEvents.visible`. Default: all regions.
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

  /** Whether the first surface is resident, or it is known that there is none. */
  get hasFirstSurface(): boolean {
    return this.#parts.coarse.hasFirstSurface;
  }

  /** As hasFirstSurface, and the surface was passed to `StreamEvents.visible`. */
  get showsFirstSurface(): boolean {
    return this.hasFirstSurface && !this.#selecting.isRequested;
  }

  /** The finest of the levels that are resident as long as the volume is open. */
  get finestCoarseLevel(): number {
    return this.#parts.coarse.finestLevel;
  }

  /** The size of the bootstrap range, with which the store was opened, in bytes. */
  get firstCoarseBytes(): number {
    return this.isClosed ? 0 : this.#store.bootstrapRange().bytes;
  }

  /** The cost of these isovalues at each level whose directory has been fetched. */
  levelCosts(isovalues: readonly number[]): LevelCost[] {
    return this.isClosed ? [] : levelCosts(this.#store, isovalues);
  }

  /** The finest level that a view shows, among the levels whose directory has been fetched. */
  finestLevelOf(view: CameraView): number {
    return this.isClosed ? 0 : this.#parts.selectionLoop.finestLevelOf(view);
  }

  /** Access to the store for readers other than the view, such as web/mesh. */
  get access(): StoreAccess {
    const closed = this.#closing.signal;
    return { source: this.source, store: this.#store, backoff: this.#backoff, closed };
  }

  /** See ValueMapping::quantized_isovalue. */
  quantizedIsovalue(isovalue: number): number {
    return this.#store.quantizedIsovalue(isovalue);
  }

  /**
   * Fetches the values of a field of the store for all chunks that are drawn (`StreamEvents.fieldValues`), or those
   * of none. The viewer forgets the values of another field. Throws a RangeError if the store has no such field.
   */
  showField(name: string | null): void {
    const field = name === null ? null : this.info.fields.find((each) => each.name === name);
    if (field === undefined) throw new RangeError(`the store has no field "${name}"`);
    if (this.isClosed) return;
    this.#parts.uploads.fields.show(field);
    this.#applyBudget();
  }

  /** The field that is shown. */
  get shownField(): ShownField | null {
    const { fields } = this.#parts.uploads;
    const info = fields.shown;
    return info && { info, metadata: fields.metadata ?? {} };
  }

  /**
   * The range of the shown field's values around the drawn surfaces, without the lowest and highest hundredth of
   * them. Undefined while there are no values.
   */
  get fieldRange(): [number, number] | undefined {
    return this.#parts.uploads.fields.surfaceRange(0.01);
  }

  /** The labels around the drawn surfaces, if the values of the shown field are categories. */
  get fieldLabels(): ReadonlySet<number> {
    return this.#parts.uploads.fields.labels;
  }

  /** How often the shown field's values occur around the drawn surfaces. */
  get fieldHistogram(): Bins | undefined {
    return this.#parts.uploads.fields.histogram;
  }

  /** Call it when opacity or clipping has changed, because this changes the occlusion. */
  sceneChanged(): void {
    this.#parts.occlusion.viewChanged();
    this.#updateProgress();
  }

  /**
   * Call it when the picture of other volumes has changed. Occluded regions of this volume may then
   * have become visible, so the same view needs another query.
   */
  otherPictureChanged(): void {
    if (this.isClosed) return;
    const { occlusion } = this.#parts;
    const wasDone = occlusion.done;
    occlusion.pictureChanged();
    if (occlusion.done) return;
    this.#events.testOcclusion?.();
    if (wasDone) this.#updateProgress();
  }

  /** The samples that stay resident as long as the volume is open. */
  get pinnedSamples(): number {
    return this.#parts.uploads.residency.pinnedSamples;
  }

  /**
   * The occlusion query that is needed for the picture as it is drawn now, or undefined: see
   * `StreamEvents.testOcclusion`. `settled`: the picture would be the same at rest.
   */
  occlusionQuery(settled: boolean): OcclusionQuery | undefined {
    return this.isClosed ? undefined : this.#parts.occlusion.query(settled);
  }

  /**
   * Whether everything visible is resident according to fast pictures, so that only a query of the
   * resting picture is missing for the view to be complete.
   */
  get needsRestingPicture(): boolean {
    return !this.isClosed && this.#parts.occlusion.needsRest;
  }

  /** `answers`: the result of the query, `visibilityWords` (core) for each drawn chunk. */
  answerOcclusion(query: OcclusionQuery, answers: Uint32Array, settled: boolean): void {
    if (this.isClosed) return;
    measured("isosplat:streaming", () => {
      if (this.#parts.occlusion.record(query, settled)) this.#store.setVisibility(answers);
    });
    this.#selecting.request();
  }

  /**
   * From now on, occluded chunks are fetched as well, because occlusion queries do not work, or take more time than
   * they save.
   */
  fetchOccluded(): void {
    if (this.#parts.selectionLoop.disableOcclusion()) this.#select();
  }

  /**
   * Retries at once all requests that wait for their next attempt, all damaged parts, and all chunks
   * that did not fit into memory.
   */
  retry(): void {
    if (this.isClosed) return;
    this.#parts.uploads.retry();
    this.#backoff.wake();
    this.#selecting.request();
    this.#retryParts();
  }

  /** Changes `StreamOptions.sampleBudget`. Memory above it is freed when coarser chunks are drawn. */
  setSampleBudget(samples: number): void {
    this.#sampleBudget = samples;
    this.#applyBudget();
  }

  /** The values of a field take as much memory as the samples. */
  #applyBudget(): void {
    const { queue, selectionLoop, uploads } = this.#parts;
    const samples = this.shownField ? Math.floor(this.#sampleBudget / 2) : this.#sampleBudget;
    if (this.isClosed || samples === uploads.residency.budget) return;
    uploads.residency.setBudget(samples);
    const isSameView = selectionLoop.fits(samples) && !queue.full && !uploads.overflow;
    if (isSameView) this.#updateProgress();
    else this.#select();
  }

  /** The values of a field at these chunks (`fieldValues`) did not fit into GPU memory. */
  rejectFieldValues(ids: readonly number[], message: string): void {
    if (!this.isClosed) this.#parts.uploads.fields.reject(ids, message);
  }

  /** The viewer accepted these chunks (`samples`), but they did not fit into GPU memory. */
  rejectUploads(ids: readonly number[], message: string): void {
    if (this.isClosed) return;
    const lost = this.#parts.uploads.reject(ids, message);
    // A chunk is dropped only after it has left the picture.
    this.#select();
    for (const id of lost) this.#events.drop(id);
  }

  /** Cancels all requests, drops every chunk (`drop`), and frees all memory. No event follows. */
  close(): void {
    if (this.isClosed) return;
    this.#isClosed = true;
    this.#closing.abort(new DOMException("the volume was closed", "AbortError"));
    this.#parts.motion.close();
    this.#selecting.cancel();
    this.#progress.close();
    this.#parts.queue.close();
    this.#parts.pages.close();
    this.#parts.background.close();
    this.#parts.readAhead.close();
    this.#parts.uploads.close();
    this.#backoff.close();
    if (this.#ownsDecoder) this.#decoder.close();
    try {
      this.#parts.uploads.residency.dropAll();
      this.#store.close();
    } catch (error) {
      // The memory of an aborted instance is freed with the instance.
      if (!(error instanceof WebAssembly.RuntimeError)) throw error;
    }
  }

  /** Chunks that no view needed when they were fetched do not change a complete picture. */
  #onAdvance(): void {
    if (this.isClosed) return;
    if (this.#isComplete) this.#updateProgress();
    else this.#selecting.request();
  }

  #loadCoarse(firstIsovalues: readonly number[] | undefined): void {
    const suggested = (this.info.metadata.suggested_isovalues ?? []).slice(0, 1);
    const { budget } = this.#parts.uploads.residency;
    void this.#parts.coarse.load(budget, firstIsovalues ?? suggested, this.#closing.signal);
  }

  #select(): void {
    const cameraView = this.#parts.motion.view;
    this.#selecting.cancel();
    if (!cameraView || this.isClosed) return;
    measured("isosplat:streaming", () => {
      try {
        this.#parts.selectionLoop.run(cameraView);
        this.#drawFields();
      } catch (error) {
        this.#report(new StreamError("internal", `selection: ${String(error)}`, error));
      }
      this.#updateProgress();
    });
  }

  #drawFields(): void {
    const { uploads, selectionLoop, motion } = this.#parts;
    const { drawn, selection } = selectionLoop;
    uploads.fields.draw({ drawn, load: selection?.load ?? [], isMoving: motion.isovalueMoves });
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
    this.#parts.queue.retry();
    this.#parts.pages.retry();
    this.#parts.uploads.fields.retry();
    this.#updateProgress();
  }

  #onPartFailed(error: StreamError, isFirst: boolean): void {
    // Occlusion queries that waited for this part continue without it.
    this.#selecting.request();
    if (isFirst) this.#report(error);
    void this.#parts.sourceCheck.run(error);
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
    const { background, readAhead, motion } = this.#parts;
    const isovalues = motion.view?.isovalues;
    const isFailing =
      this.#parts.sourceCheck.isReplaced || this.#backoff.trouble || this.#parts.uploads.overflow;
    if (!isovalues || isFailing || !this.#isComplete) this.#stopReadingAhead();
    else if (background.isDone) readAhead.start(isovalues, motion.direction);
    else background.start(isovalues, this.#parts.coarse.finestLevel);
  }

  #stopReadingAhead(): void {
    this.#parts.background.stop();
    this.#parts.readAhead.stop();
  }

  #currentProgress() {
    return progressOf({
      ...this.#parts,
      source: this.source,
      selection: this.#parts.selectionLoop.selection,
      isHere: this.#parts.selectionLoop.isHere,
      isSelectionPending: this.#selecting.isRequested,
      isLoadingCoarse: this.#parts.coarse.isLoading,
      preparation: this.#parts.background.preparation ?? this.#parts.readAhead.preparation,
      sourceFault: this.#backoff.trouble,
    });
  }

  #mark(name: string): void {
    markTimeline(name, this.source, this.#parts.uploads.residency);
  }
}
