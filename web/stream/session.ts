import {
  type Chunk,
  type Core,
  CoreError,
  type CoreSelection,
  type Points,
  type Store,
} from "../core/index.ts";
import { Backoff } from "./backoff.ts";
import { ChunkQueue } from "./chunk_queue.ts";
import { CoalescedTask } from "./coalesced_task.ts";
import { badDirectory, CoarseTail } from "./coarse_tail.ts";
import type { Decoder } from "./decoder.ts";
import { defaultSampleBudget } from "./device.ts";
import { type FaultKind, faultOfStatus, isOfPart } from "./faults.ts";
import { Motion } from "./motion.ts";
import { OcclusionQueries, type OcclusionQuery } from "./occlusion_queries.ts";
import { PageLoader } from "./page_loader.ts";
import { Prefetch } from "./prefetch.ts";
import { Residency } from "./residency.ts";
import type { Source } from "./source.ts";
import { measured } from "./timeline.ts";
import { beginsAsStore } from "./transfer.ts";
import {
  type CameraView,
  type ChunkPlace,
  type Progress,
  type StoreInfo,
  StreamError,
  type StreamEvents,
  type StreamOptions,
} from "./types.ts";
import { UploadQueue } from "./upload_queue.ts";
import { WorkerPool } from "./worker_pool.ts";

/**
 * The refined view may take this share of what the budget leaves beside the coarse levels: while
 * finer chunks replace coarser ones, both are held.
 */
const targetShare = 0.75;
/** While the isovalue moves, at most so much is fetched ahead at a time. */
const aheadBytes = 160 * 1024;

/** Progress is told at most so often, unless its state changes (ms). */
const progressInterval = 60;

/** Where there was no room for what is held, so much of it is aimed at from then on. */
const shareAfterOverflow = 0.75;

/** One open volume: fetches, decodes and keeps what the current view needs. See README.md. */
export class StreamSession {
  readonly info: StoreInfo;
  readonly source: Source;
  readonly #store: Store;
  readonly #events: StreamEvents;
  readonly #decoder: Decoder;
  readonly #ownsDecoder: boolean;
  readonly #backoff: Backoff;
  readonly #queue: ChunkQueue;
  readonly #coarseTail: CoarseTail;
  readonly #pages: PageLoader;
  readonly #uploads: UploadQueue;
  readonly #residency: Residency;
  readonly #motion: Motion;
  readonly #prefetch = new Prefetch();
  readonly #visibility = new OcclusionQueries();
  readonly #targetPixels: number;
  readonly #movingPixels: number;
  readonly #firstIsovalues: readonly number[];
  readonly #closing = new AbortController();
  /** After something has arrived. What is looked at is selected for at once. */
  readonly #selecting = new CoalescedTask(() => this.#select());

  /** Occlusion queries are answered. */
  #reportsOcclusion: boolean;
  #view: CameraView | undefined;
  #selection: CoreSelection | undefined;
  /** The finest level of the coarse tail, and whether that is still on its way. */
  readonly #coarse: { finestLevel: number; loading: boolean };
  /** Until the first surface is there, nothing finer competes with it for the link. */
  #awaitsSurface = true;
  #visible: Uint32Array = new Uint32Array();
  #regions: Uint32Array = new Uint32Array();
  #told = { text: "", state: "", at: 0 };
  #tellTimer: ReturnType<typeof setTimeout> | undefined;
  /** What the GPU, or the main thread, could not take. */
  #overflow: StreamError | undefined;
  /** Not asked for again until `retry`. */
  readonly #notTaken = new Set<number>();
  #isExamining = false;
  #isReplaced = false;

  private constructor(
    source: Source,
    store: Store,
    backoff: Backoff,
    options: StreamOptions & { decoder?: Decoder },
  ) {
    this.source = source;
    this.info = store.info;
    this.#store = store;
    this.#events = options.events;
    this.#reportsOcclusion = options.events.testOcclusion !== undefined;
    this.#ownsDecoder = !options.decoder;
    this.#decoder = options.decoder ?? new WorkerPool();
    this.#backoff = backoff;
    this.#targetPixels = options.targetCellPixels ?? 1;
    this.#movingPixels = options.movingCellPixels ?? 5;
    this.#firstIsovalues =
      options.firstIsovalues ?? (this.info.metadata.suggested_isovalues ?? []).slice(0, 1);
    this.#coarseTail = new CoarseTail(source, store, backoff);
    this.#coarse = { finestLevel: this.#coarseTail.finestLevel, loading: true };
    this.#residency = new Residency(store, options.sampleBudget ?? defaultSampleBudget(), (id) =>
      this.#events.drop(id),
    );
    this.#uploads = new UploadQueue(
      (chunk, samples, pinned) => this.#upload(chunk, samples, pinned),
      () => this.#selecting.request(),
    );
    this.#motion = new Motion(() => this.#select());
    this.#queue = new ChunkQueue(source, this.#decoder, backoff, {
      admit: (chunk) => this.#residency.reserve(chunk),
      decoded: (chunk, samples) => this.#uploads.add(chunk, samples, false),
      released: (chunk) => this.#residency.release(chunk.handle),
      failed: (error, isFirst) => this.#partFailed(error, isFirst),
      changed: () => this.#tell(),
    });
    this.#pages = new PageLoader(source, store, backoff, this.#closing.signal, {
      added: () => this.#selecting.request(),
      failed: (error, isFirst) => this.#partFailed(error, isFirst),
    });
  }

  get isClosed(): boolean {
    return this.#closing.signal.aborted;
  }

  /** Reads the store's header and starts to fetch the coarse levels. Rejects with a StreamError. */
  static async open(
    source: Source,
    core: Core,
    options: StreamOptions & { decoder?: Decoder },
  ): Promise<StreamSession> {
    const signal = options.signal ?? new AbortController().signal;
    let session: StreamSession | undefined;
    const backoff = new Backoff({
      trouble: (error) => {
        if (session) session.#sourceTroubled(error);
        else if (error) options.events.error(error);
      },
      slow: (error) => {
        if (session) void session.#examine(error);
      },
    });
    try {
      const store = await openStore(source, core, backoff, signal);
      signal.throwIfAborted();
      session = new StreamSession(source, store, backoff, options);
      const opened = session;
      signal.addEventListener("abort", () => opened.close(), { once: true });
      void session.#loadCoarse();
      return session;
    } catch (error) {
      backoff.close();
      throw error;
    }
  }

  /** What is looked at now. Cheap when nothing has changed; call it once per frame at most. */
  update(view: CameraView): void {
    if (this.isClosed) return;
    if (!this.#motion.changed(view)) return;
    this.#visibility.viewChanged();
    this.#view = {
      ...view,
      viewProjection: Array.from(view.viewProjection),
      isovalues: [...view.isovalues],
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

  /** Something other than the view has changed that decides what is hidden: opacity, clipping. */
  sceneChanged(): void {
    this.#visibility.viewChanged();
    this.#tell();
  }

  /**
   * The occlusion query that is wanted of the picture as it is drawn now, if any: see
   * `StreamEvents.testOcclusion`. `settled`: when the view rests, it would be drawn no differently.
   */
  occlusionQuery(settled: boolean): OcclusionQuery | undefined {
    return this.isClosed ? undefined : this.#visibility.query(settled);
  }

  /** The answer: `visibilityWords` (core) for each chunk that was drawn. */
  answerOcclusion(query: OcclusionQuery, answers: Uint32Array, settled: boolean): void {
    if (this.isClosed) return;
    measured("isosplat:streaming", () => {
      if (this.#visibility.take(query, settled)) this.#store.setVisibility(answers);
    });
    this.#selecting.request();
  }

  /** No answers come any more: from now on, what is hidden is fetched as well. */
  occlusionFailed(): void {
    this.#reportsOcclusion = false;
    this.#select();
  }

  /** Tries again at once what waits for its next try, what is damaged, and what had no room. */
  retry(): void {
    if (this.isClosed) return;
    this.#overflow = undefined;
    this.#notTaken.clear();
    this.#residency.restoreBudget();
    this.#backoff.wake();
    this.#queue.retry();
    this.#pages.retry();
    this.#selecting.request();
    this.#tell();
  }

  /** These were handed over (`samples`), but the GPU does not have them after all. */
  notTaken(ids: readonly number[], message: string): void {
    if (this.isClosed) return;
    const lost = ids.filter((id) => this.#residency.lose(id));
    this.#overflowed(message, lost);
    // What is drawn is told before it is dropped.
    this.#select();
    for (const id of lost) this.#events.drop(id);
  }

  /** Cancels what is under way, drops every chunk (`drop`), and frees all memory. No event follows. */
  close(): void {
    if (this.isClosed) return;
    this.#closing.abort(new DOMException("the volume was closed", "AbortError"));
    this.#motion.close();
    this.#selecting.cancel();
    clearTimeout(this.#tellTimer);
    this.#queue.close();
    this.#pages.close();
    this.#uploads.close();
    this.#backoff.close();
    if (this.#ownsDecoder) this.#decoder.close();
    try {
      this.#residency.dropAll();
      this.#store.close();
    } catch (error) {
      // An instance that has aborted goes as a whole.
      if (!(error instanceof WebAssembly.RuntimeError)) throw error;
    }
  }

  /** The coarse tail, for every isovalue, the first view's isovalues before the others. */
  async #loadCoarse(): Promise<void> {
    const { signal } = this.#closing;
    const decoding: Promise<void>[] = [];
    const quantizedIsovalues = this.#firstIsovalues.map((isovalue) =>
      this.#store.quantizedIsovalue(isovalue),
    );
    const isFirst = ({ bandBegin, bandEnd }: Chunk): boolean =>
      quantizedIsovalues.some(
        (quantizedIsovalue) => bandBegin <= quantizedIsovalue && quantizedIsovalue < bandEnd,
      );
    try {
      const finest = await this.#coarseTail.load(this.#residency.budget, signal, (chunks) => {
        const urgent = chunks.filter(({ chunk }) => isFirst(chunk));
        const others = chunks.filter(({ chunk }) => !isFirst(chunk));
        const first = urgent.map(({ chunk, bytes }) => this.#decodeCoarse(chunk, bytes));
        decoding.push(...first);
        for (const { chunk, bytes } of others) decoding.push(this.#decodeCoarse(chunk, bytes));
        this.#selecting.request();
        return Promise.all(first)
          .then(() => this.#uploads.drained())
          .then(() => this.#surfaceArrived());
      });
      this.#coarse.finestLevel = finest;
      await Promise.all(decoding);
    } catch (error) {
      if (this.isClosed) return;
      this.#report(error instanceof StreamError ? error : badDirectory(error));
    }
    // What is missing of it now has failed, and is asked for as any other chunk.
    this.#coarse.loading = false;
    this.#surfaceArrived();
  }

  #surfaceArrived(): void {
    this.#awaitsSurface = false;
    this.#selecting.request();
  }

  async #decodeCoarse(chunk: Chunk, bytes: Uint8Array): Promise<void> {
    if (this.#residency.has(chunk.handle)) return;
    try {
      const samples = await this.#decoder.decode(chunk, bytes, this.#closing.signal);
      this.#uploads.add(chunk, samples, true);
    } catch (error) {
      if (error instanceof CoreError && error.status === "checksum_mismatch") {
        this.source.bypassCaches();
      }
    }
  }

  #upload(chunk: Chunk, samples: Uint32Array, pinned: boolean): void {
    if (this.#residency.has(chunk.handle)) {
      this.#residency.release(chunk.handle);
    } else if (this.#events.samples(chunk.handle, chunk, samples)) {
      this.#residency.add(chunk.handle, samples.length / 4, pinned);
    } else {
      this.#residency.release(chunk.handle);
      this.#overflowed("the graphics card has no room for more samples", [chunk.handle]);
    }
  }

  /** From now on less is held than what there was no room for. */
  #overflowed(message: string, ids: readonly number[]): void {
    for (const id of ids) this.#notTaken.add(id);
    this.#residency.limit(this.#residency.samples * shareAfterOverflow);
    const isFirst = !this.#overflow;
    this.#overflow = new StreamError("out-of-memory", message);
    if (isFirst) this.#report(this.#overflow);
    this.#selecting.request();
  }

  /** The source fails and goes on failing; or it is in order again. */
  #sourceTroubled(error: StreamError | undefined): void {
    if (this.isClosed) return;
    if (!error) {
      this.#queue.retry();
      this.#pages.retry();
      this.#tell();
      return;
    }
    // Who opens it anew is told of that alone.
    if (error.kind === "replaced") this.#tell();
    else this.#report(error);
  }

  #partFailed(error: StreamError, isFirst: boolean): void {
    if (isFirst) this.#report(error);
    void this.#examine(error);
  }

  /**
   * Bytes are missing, or are not what they should be: asks what is at the address now. Another
   * store: this one was replaced. Nothing, or one that is broken: that is the cause.
   */
  async #examine(error: StreamError): Promise<void> {
    if (this.#isExamining || this.#isReplaced || !isOfStore(error.kind)) return;
    this.#isExamining = true;
    try {
      const contentId = await this.source.contentId(this.#closing.signal);
      const found = this.source.fileBytes;
      if (contentId !== this.info.contentId) {
        this.#isReplaced = true;
        const text = `${this.source.name}: expected the store ${this.info.contentId}, found ${contentId}`;
        this.#events.replaced(new StreamError("replaced", text, error));
      } else if (found !== undefined && found < this.info.fileBytes) {
        this.#backoff.explain(cutShort(this.source.name, this.info.fileBytes, found));
      } else if (!isOfPart(error.kind) && error.kind !== "cut-short") {
        // It is there, as it was.
        this.#backoff.hasten();
      }
    } catch (reason) {
      if (this.isClosed) return;
      if (reason instanceof StreamError && !reason.retrying) this.#backoff.explain(reason);
    } finally {
      this.#isExamining = false;
    }
  }

  /** What the view needs now: draws what is there, asks for what is not. */
  #select(): void {
    const view = this.#view;
    this.#selecting.cancel();
    if (!view || this.isClosed) return;
    measured("isosplat:streaming", () => this.#selectFor(view));
  }

  #selectFor(view: CameraView): void {
    const left = this.#residency.budget - this.#residency.pinnedSamples;
    const asked = {
      viewProjection: view.viewProjection,
      width: view.viewport.width,
      height: view.viewport.height,
      loadCellPixels: this.#motion.cameraMoves ? this.#movingPixels : this.#targetPixels,
      drawCellPixels: this.#targetPixels,
      cellBudget: Math.max(0, left * targetShare),
      occlusion: this.#asksForOcclusion(),
    };
    try {
      const selection = this.#store.select({ ...asked, isovalues: view.isovalues });
      this.#selection = selection;
      this.#residency.use(selection.drawn, selection.keep, this.#visible);
      this.#show(selection);
      const isMoreWanted =
        selection.load.length > 0 || selection.pages.length > 0 || selection.undecided > 0;
      this.#visibility.need(asked.occlusion ? selection.test : undefined, isMoreWanted);
      if (!this.#visibility.done) this.#events.testOcclusion?.();
      this.#pages.need(this.#pagesToFetch(selection));
      const needed = selection.load.filter((chunk) => this.#isToBeFetched(chunk));
      if (this.#motion.isovalueMoves) {
        const ahead = this.#ahead(asked);
        this.#queue.need(this.#prefetch.select(needed, this.#queue.underway(), ahead));
      } else {
        this.#prefetch.end();
        this.#queue.need(needed);
      }
    } catch (error) {
      this.#report(new StreamError("internal", `selection: ${String(error)}`, error));
    }
    this.#tell();
  }

  /** While something moves, little is fetched anyway, and an answer would come too late. */
  #asksForOcclusion(): boolean {
    const moves = this.#motion.cameraMoves || this.#motion.isovalueMoves;
    return this.#reportsOcclusion && !moves;
  }

  /** The first chunks for where the isovalue is going, when it goes slowly enough to use them. */
  #ahead(asked: Omit<Parameters<Store["select"]>[0], "isovalues">): Chunk[] {
    const [low, high] = this.info.range;
    const isovalues = this.#motion.isovaluesAhead(high - low);
    if (!isovalues) return [];
    const next = this.#store.select({
      ...asked,
      isovalues,
      loadCellPixels: this.#movingPixels,
      ahead: true,
    });
    const now = this.#selection ? this.#pagesToFetch(this.#selection) : [];
    this.#pages.need([...now, ...this.#pagesToFetch(next)]);
    const chunks: Chunk[] = [];
    let bytes = 0;
    for (const chunk of next.load) {
      if (!this.#isToBeFetched(chunk)) continue;
      bytes += chunk.bytes;
      if (bytes > aheadBytes) break;
      chunks.push(chunk);
    }
    return chunks;
  }

  #isToBeFetched(chunk: Chunk): boolean {
    return (
      !this.#awaitsSurface &&
      !this.#isReplaced &&
      !this.#comesAnyway(chunk.level) &&
      !this.#uploads.has(chunk.handle) &&
      !this.#notTaken.has(chunk.handle)
    );
  }

  #pagesToFetch(selection: CoreSelection): number[] {
    if (this.#isReplaced) return [];
    return selection.pages.filter((page) => !this.#comesAnyway(this.#pages.level(page)));
  }

  /** The coarse tail brings it. */
  #comesAnyway(level: number): boolean {
    return this.#coarse.loading && level >= this.#coarse.finestLevel;
  }

  #show(selection: CoreSelection): void {
    if (same(selection.drawn, this.#visible) && same(selection.regions, this.#regions)) return;
    if (this.#visible.length === 0) this.#mark("isosplat:surface");
    this.#visibility.pictureChanged();
    this.#visible = selection.drawn;
    this.#regions = selection.regions;
    this.#events.visible(selection.drawn.slice(), selection.regions.slice());
  }

  /** On the browser's timeline, for benchmarks and for whoever looks there: see README.md. */
  #mark(name: string): void {
    const { name: volume, bytesReceived, requests } = this.source;
    const { samples: samplesResident, budget: sampleBudget } = this.#residency;
    const detail = { volume, bytesReceived, requests, samplesResident, sampleBudget };
    // The last one of each name is kept: the timeline forgets nothing by itself.
    performance.clearMarks?.(name);
    performance.mark?.(name, { detail });
  }

  #report(error: StreamError): void {
    this.#events.error(error);
    this.#tell();
  }

  /** Tells progress: a new state at once, new numbers now and then. */
  #tell(): void {
    if (this.isClosed) return;
    const progress = this.#progress();
    const text = JSON.stringify(progress);
    if (text === this.#told.text) return;
    const now = performance.now();
    if (progress.state === this.#told.state && now - this.#told.at < progressInterval) {
      this.#tellTimer ??= setTimeout(() => {
        this.#tellTimer = undefined;
        this.#tell();
      }, progressInterval);
      return;
    }
    if (progress.state !== this.#told.state) {
      if (progress.state === "complete") this.#mark("isosplat:complete");
      if (progress.state === "limited") this.#mark("isosplat:limited");
    }
    this.#told = { text, state: progress.state, at: now };
    this.#events.progress(progress);
  }

  #progress(): Progress {
    const selection = this.#selection;
    const load = selection?.load ?? [];
    const isFailed = ({ handle }: Chunk): boolean =>
      this.#queue.state(handle) === "failed" || this.#notTaken.has(handle);
    const isIdle =
      selection !== undefined &&
      !this.#selecting.isRequested &&
      !this.#coarse.loading &&
      this.#uploads.empty;
    const isSettled =
      isIdle &&
      load.every(isFailed) &&
      selection.pages.every((page) => this.#pages.isDamaged(page)) &&
      selection.undecided === 0 &&
      this.#visibility.answered;
    const nothingToGo =
      isSettled && load.length === 0 && selection.pages.length === 0 && this.#visibility.done;
    // What is wanted finds no room, and nothing that is under way could make some.
    const isFull = isIdle && load.length > 0 && this.#queue.full && this.#queue.idle;
    const limitedByBudget = (selection?.limitedByBudget ?? false) || this.#queue.full;
    const isDrawn = (selection?.finestLevel ?? -1) >= 0;
    const moves = this.#motion.isovalueMoves || this.#motion.cameraMoves;
    const trouble = nothingToGo ? undefined : this.#backoff.trouble;
    let state: Progress["state"] = "refining";
    if (trouble) state = trouble.retrying ? "offline" : "incomplete";
    else if ((nothingToGo || isFull) && !moves) state = limitedByBudget ? "limited" : "complete";
    else if (!isDrawn && this.#coarse.loading) state = "opening";
    else if (moves) state = "waiting";
    else if (isSettled && !nothingToGo && load.length + selection.pages.length > 0) {
      state = "incomplete";
    }
    const [chunks, pages] = [this.#queue.damaged, this.#pages.damaged];
    const fault = trouble ?? pages.error ?? chunks.error ?? this.#overflow;
    return {
      state,
      chunksToGo: load.length,
      bytesToGo: load.reduce((bytes, chunk) => bytes + chunk.bytes, 0),
      bytesFetched: this.source.bytesReceived,
      requests: this.source.requests,
      chunksResident: this.#residency.chunks,
      samplesResident: this.#residency.samples,
      sampleBudget: this.#residency.budget,
      finestLevel: selection?.finestLevel ?? -1,
      coarsestLevel: selection?.coarsestLevel ?? -1,
      limitedByBudget,
      complete: state === "complete",
      damagedParts: chunks.count + pages.count,
      fault: fault ? { kind: fault.kind, message: fault.message } : null,
    };
  }
}

/** What the address holds decides over these; of others it says nothing. */
function isOfStore(kind: FaultKind): boolean {
  return !["cors-refused", "worker-lost", "out-of-memory", "internal"].includes(kind);
}

function cutShort(name: string, expected: number, found: number): StreamError {
  return new StreamError(
    "cut-short",
    `${name}: expected ${expected} bytes, found ${found}: rebuild the store, or copy it again`,
  );
}

/**
 * Fetches the header and opens it. One that cannot be read is fetched once more, as a whole and past
 * the caches, unless it has just been fetched so.
 */
async function openStore(
  source: Source,
  core: Core,
  backoff: Backoff,
  signal: AbortSignal,
): Promise<Store> {
  let whole = source.fresh;
  for (;;) {
    const header = await backoff.retry(signal, () => source.header(signal, whole));
    let store: Store;
    try {
      store = core.openStore(header);
    } catch (error) {
      const status = error instanceof CoreError ? error.status : "internal";
      // More of it, where it has turned out longer; and whatever is wrong, past the caches.
      if (!whole && status !== "internal") {
        if (status !== "truncated") source.bypassCaches();
        whole = true;
        continue;
      }
      const message = error instanceof Error ? error.message : String(error);
      const kind = faultOfStatus(status) ?? "internal";
      const isNone = kind === "cut-short" && !beginsAsStore(header);
      const ofHeader = isOfPart(kind) ? "damaged-header" : isNone ? "not-a-store" : kind;
      throw new StreamError(ofHeader, `${source.name}: ${message}`, error);
    }
    const [expected, found] = [store.info.fileBytes, source.fileBytes];
    if (found === undefined || found >= expected) return store;
    store.close();
    throw cutShort(source.name, expected, found);
  }
}

function same(a: Uint32Array, b: Uint32Array): boolean {
  return a.length === b.length && a.every((word, i) => word === b[i]);
}
