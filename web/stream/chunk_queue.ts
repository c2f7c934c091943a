import { CoreError } from "../core/calls.ts";
import type { Chunk } from "../core/records.ts";
import type { Backoff } from "./backoff.ts";
import { CoalescedTask } from "./coalesced_task.ts";
import { FailedParts } from "./failed_parts.ts";
import { type FaultKind, faultOfStatus, isOfPart } from "./faults.ts";
import { RequestLimit, type RequestShare } from "./request_limit.ts";
import { PartError, type Source } from "./source.ts";
import { measured } from "./timeline.ts";
import { StreamError } from "./types.ts";

/** See README.md. A chunk that is not in the queue is `known` or `resident`. */
export type ChunkState = "queued" | "loading" | "decoding" | "failed";

/** While this many chunks are being decoded, no request starts. */
const maxDecoding = 64;
/** The next requests are composed of this many of the most needed chunks. */
const chunksPlanned = 256;
/** A chunk counts as damaged after this many failed requests while others succeed. */
const maxTries = 6;

interface Entry {
  chunk: Chunk;
  state: ChunkState;
  /** Order of need, from 0. Infinity: no longer needed. */
  rank: number;
  /** Number of times that its bytes did not match the directory. */
  refused: number;
  /** Requests for it that failed. */
  tries: number;
  /** Whether it is requested alone, because a response with many chunks would end at this one. */
  alone: boolean;
  /** It has failed before. If it succeeds, the other failed chunks are retried. */
  hasFailed: boolean;
}

interface Group {
  entries: Set<Entry>;
  abort: AbortController;
}

/** Decodes what the queue fetches. Takes ownership of the bytes. Rejects with a CoreError or the signal's reason. */
export interface ChunkDecoder<Decoded> {
  decode(chunk: Chunk, bytes: Uint8Array, signal: AbortSignal): Promise<Decoded>;
}

export interface QueueEvents<Decoded> {
  /** Reserves memory for a chunk before its request. Returns false if there is none. */
  admit(chunk: Chunk): boolean;
  /** The chunk is decoded; it leaves the queue. */
  decoded(chunk: Chunk, decoded: Decoded): void;
  /** An admitted chunk will not be decoded: its memory is free. */
  released(chunk: Chunk): void;
  /**
   * A chunk is damaged. `isFirst`: no other needed chunk is damaged, and this one has not failed
   * before.
   */
  failed(error: StreamError, isFirst: boolean): void;
  changed(): void;
}

/** Fetches and decodes needed chunks in order of need, and cancels the others. */
export class ChunkQueue<Decoded> {
  readonly #source: Source;
  readonly #decoder: ChunkDecoder<Decoded>;
  readonly #backoff: Backoff;
  readonly #events: QueueEvents<Decoded>;
  readonly #entries = new Map<number, Entry>();
  readonly #groups = new Set<Group>();
  readonly #requests: RequestShare;
  readonly #closing = new AbortController();
  readonly #pumping = new CoalescedTask(() => measured("isosplat:streaming", () => this.#pump()));
  #decoding = 0;
  #waking = false;
  #refusedRoom = false;
  readonly #failed = new FailedParts<Entry>(
    ({ rank }) => rank < Number.POSITIVE_INFINITY,
    (entry) => {
      entry.state = "queued";
      entry.alone = true;
      this.#pumping.request();
    },
  );

  /** `limit`: limits the requests of several queues together. */
  constructor(
    source: Source,
    decoder: ChunkDecoder<Decoded>,
    backoff: Backoff,
    events: QueueEvents<Decoded>,
    limit = new RequestLimit(),
  ) {
    this.#requests = limit.join(
      () => source.concurrency,
      () => this.#pumping.request(),
    );
    this.#source = source;
    this.#decoder = decoder;
    this.#backoff = backoff;
    this.#events = events;
  }

  state(handle: number): ChunkState | undefined {
    return this.#entries.get(handle)?.state;
  }

  /** Nothing is loading or decoding. */
  get idle(): boolean {
    return this.#groups.size === 0 && this.#decoding === 0;
  }

  /** There was no memory for the next chunk to request. */
  get full(): boolean {
    return this.#refusedRoom;
  }

  /** The number of damaged chunks that are needed, and the error of the first. */
  get damaged(): { count: number; error: StreamError | undefined } {
    return this.#failed.needed;
  }

  /** Requests damaged chunks again. */
  retry(): void {
    this.#failed.retryAll();
  }

  /** Sets the chunks that are needed and not resident, the most needed first. */
  need(chunks: readonly Chunk[]): void {
    for (const entry of this.#entries.values()) entry.rank = Number.POSITIVE_INFINITY;
    chunks.forEach((chunk, rank) => {
      const entry = this.#entries.get(chunk.handle);
      if (entry) entry.rank = rank;
      else {
        const count = { refused: 0, tries: 0, alone: false, hasFailed: false };
        this.#entries.set(chunk.handle, { chunk, state: "queued", rank, ...count });
      }
    });
    for (const [handle, entry] of this.#entries) {
      if (entry.rank === Number.POSITIVE_INFINITY && entry.state === "queued") {
        this.#entries.delete(handle);
      }
    }
    for (const group of this.#groups) {
      if (![...group.entries].some((entry) => entry.rank < Number.POSITIVE_INFINITY)) {
        group.abort.abort(new DOMException("no longer needed", "AbortError"));
      }
    }
    if (this.#entries.size > 0) this.#pumping.request();
    else this.#refusedRoom = false;
  }

  /** Pauses and resumes the requests of all queues with the same limit. */
  pauseAll(isPaused: boolean): void {
    if (isPaused) this.#requests.pause();
    else this.#requests.resume();
  }

  /** Chunks that are loading or decoding. */
  *underway(): Iterable<Chunk> {
    for (const { chunk, state } of this.#entries.values()) {
      if (state === "loading" || state === "decoding") yield chunk;
    }
  }

  close(): void {
    this.#closing.abort(new DOMException("the volume was closed", "AbortError"));
    this.#pumping.cancel();
    this.#failed.close();
    for (const group of this.#groups) group.abort.abort(this.#closing.signal.reason);
    this.#entries.clear();
    this.#requests.leave();
  }

  #pump(): void {
    if (this.#closing.signal.aborted) return;
    if (this.#backoff.waiting) {
      this.#pumpWhenReady();
      return;
    }
    this.#refusedRoom = false;
    if (this.#decoding >= maxDecoding) return;
    const queued = [...this.#entries.values()]
      .filter(({ rank, state }) => rank < Number.POSITIVE_INFINITY && state === "queued")
      .sort((a, b) => a.rank - b.rank)
      .slice(0, chunksPlanned);
    if (queued.length === 0) return;
    const { free } = this.#requests;
    const groups = free > 0 ? this.#groupsOf(queued) : [];
    if (groups.length === 0 || groups.length > free) this.#requests.wait();
    for (const chunks of groups.slice(0, free)) {
      if (this.#backoff.waiting) {
        this.#pumpWhenReady();
        return;
      }
      const admitted = chunks.filter((chunk) => this.#events.admit(chunk));
      if (admitted.length > 0) void this.#load(admitted);
      if (admitted.length < chunks.length) {
        this.#refusedRoom = true;
        break;
      }
    }
  }

  #groupsOf(queued: readonly Entry[]): Chunk[][] {
    const chunks = (alone: boolean): Chunk[] =>
      queued.filter((entry) => entry.alone === alone).map((entry) => entry.chunk);
    return [...chunks(true).map((chunk) => [chunk]), ...this.#source.group(chunks(false))];
  }

  #pumpWhenReady(): void {
    if (this.#waking) return;
    this.#waking = true;
    this.#backoff.ready(this.#closing.signal).then(
      () => {
        this.#waking = false;
        this.#pumping.request();
      },
      () => {},
    );
  }

  async #load(chunks: readonly Chunk[]): Promise<void> {
    const group: Group = { entries: new Set(), abort: new AbortController() };
    for (const chunk of chunks) {
      const entry = this.#entries.get(chunk.handle);
      if (!entry) continue;
      entry.state = "loading";
      group.entries.add(entry);
    }
    this.#groups.add(group);
    this.#requests.begin();
    const ended = this.#backoff.begin();
    this.#events.changed();
    try {
      await this.#source.chunks(chunks, group.abort.signal, (chunk, bytes) => {
        const entry = this.#entries.get(chunk.handle);
        if (!entry || !group.entries.delete(entry)) return;
        if (!isOfDecoder(this.#backoff.trouble?.kind)) this.#backoff.succeeded();
        void this.#decode(entry, bytes);
      });
      if (group.entries.size > 0) throw new StreamError("internal", "the source left chunks out");
    } catch (error) {
      this.#loadFailed(group, error);
    } finally {
      this.#groups.delete(group);
      this.#requests.ended();
      ended();
      if (!this.#closing.signal.aborted) {
        this.#events.changed();
        this.#pumping.request();
      }
    }
  }

  #loadFailed(group: Group, error: unknown): void {
    const wasAborted = group.abort.signal.aborted;
    const reason =
      error instanceof StreamError ? error : new StreamError("internal", String(error), error);
    for (const entry of group.entries) {
      this.#events.released(entry.chunk);
      entry.state = "queued";
      if (wasAborted && entry.rank === Number.POSITIVE_INFINITY) {
        this.#entries.delete(entry.chunk.handle);
      }
    }
    if (wasAborted || this.#closing.signal.aborted) return;
    const [first] = group.entries;
    if (reason instanceof PartError) {
      // The other chunks of the batch are valid. Request the failed chunk alone: its response states
      // the cause.
      const broken = this.#entries.get(reason.handle);
      if (broken) broken.alone = true;
    } else if (first && group.entries.size === 1 && isOfPart(reason.kind)) {
      this.#refuse(first, reason);
    } else {
      for (const entry of group.entries) {
        if (++entry.tries >= maxTries) this.#fail(entry, reason);
      }
      // A browser may drop the last bytes of an incomplete response. These name the damaged chunk.
      if (first && first.tries > 1) first.alone = true;
      this.#backoff.failed(reason);
    }
  }

  async #decode(entry: Entry, bytes: Uint8Array): Promise<void> {
    entry.state = "decoding";
    ++this.#decoding;
    try {
      const decoded = await this.#decoder.decode(entry.chunk, bytes, this.#closing.signal);
      if (this.#closing.signal.aborted) return;
      this.#backoff.succeeded();
      this.#entries.delete(entry.chunk.handle);
      this.#events.decoded(entry.chunk, decoded);
      if (entry.hasFailed) this.#failed.retryAll();
    } catch (error) {
      if (this.#closing.signal.aborted) return;
      this.#events.released(entry.chunk);
      this.#decodeFailed(entry, error);
    } finally {
      --this.#decoding;
      if (!this.#closing.signal.aborted) {
        this.#events.changed();
        this.#pumping.request();
      }
    }
  }

  #decodeFailed(entry: Entry, error: unknown): void {
    const { level, block, band } = entry.chunk;
    const status = error instanceof CoreError ? error.status : "internal";
    const kind = faultOfStatus(status) ?? "internal";
    const message = error instanceof Error ? error.message : String(error);
    const text = `chunk ${level}/${block.join(".")}/${band}: ${message}`;
    const reason = new StreamError(kind, text, error);
    if (isOfDecoder(kind)) {
      entry.state = "queued";
      // Usually a new worker has already replaced the lost one.
      if (++entry.tries > 1) this.#backoff.failed(reason);
    } else if (status === "malformed_chunk") {
      // The checksum is right: a second request would return the same bytes.
      this.#fail(entry, reason);
    } else {
      this.#refuse(entry, reason);
    }
  }

  /** The bytes do not match the chunk's checksum. They are fetched once more, bypassing the caches. */
  #refuse(entry: Entry, error: StreamError): void {
    this.#source.bypassCaches();
    if (++entry.refused === 1) {
      entry.state = "queued";
    } else {
      this.#fail(entry, error);
    }
  }

  /** Marks a chunk as damaged. The coarser level is shown instead. */
  #fail(entry: Entry, error: StreamError): void {
    const isFirst = this.#failed.needed.count === 0 && !entry.hasFailed;
    entry.state = "failed";
    entry.hasFailed = true;
    this.#failed.add(entry, error);
    this.#events.failed(error, isFirst);
  }
}

/** Whether the decoder is the cause, and not the source. */
function isOfDecoder(kind: FaultKind | undefined): boolean {
  return kind === "worker-lost" || kind === "out-of-memory";
}
