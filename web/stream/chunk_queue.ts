import { type Chunk, CoreError, type DecodedChunk } from "../core/index.ts";
import type { Backoff } from "./backoff.ts";
import { CoalescedTask } from "./coalesced_task.ts";
import type { Decoder } from "./decoder.ts";
import { FailedParts } from "./failed_parts.ts";
import { type FaultKind, faultOfStatus, isOfPart } from "./faults.ts";
import { PartError, type Source } from "./source.ts";
import { measured } from "./timeline.ts";
import { StreamError } from "./types.ts";

/** See README.md. A chunk that the queue does not know is `known` or `resident`. */
export type ChunkState = "queued" | "loading" | "decoding" | "failed";

/** Chunks that have arrived and wait for a worker: beyond this, nothing more is asked for. */
const maxDecoding = 64;
/** Of this many of the most needed chunks the next requests are made. */
const chunksPlanned = 256;
/** A chunk whose requests fail so often while others succeed counts as damaged. */
const maxTries = 6;

interface Entry {
  chunk: Chunk;
  state: ChunkState;
  /** 0: most needed. Infinity: no longer needed. */
  rank: number;
  /** Times that its bytes were not what the directory states. */
  refused: number;
  /** Requests for it that failed. */
  tries: number;
  /** Asked for in a request of its own: an answer of many would break off at it. */
  alone: boolean;
  /** It has failed before; that it is whole now says that others may be. */
  hasFailed: boolean;
}

interface Group {
  entries: Set<Entry>;
  abort: AbortController;
}

export interface QueueEvents {
  /** Whether there is room for the chunk; called before it is asked for, and reserves it. */
  admit(chunk: Chunk): boolean;
  /** The chunk is decoded; it leaves the queue. */
  decoded(chunk: Chunk, decoded: DecodedChunk): void;
  /** An admitted chunk does not come after all. */
  released(chunk: Chunk): void;
  /** A chunk is damaged, and done without. `isFirst`: of those that are needed, and not before. */
  failed(error: StreamError, isFirst: boolean): void;
  changed(): void;
}

/** Fetches and decodes the chunks that are needed, in their order, and forgets the others. */
export class ChunkQueue {
  readonly #source: Source;
  readonly #decoder: Decoder;
  readonly #backoff: Backoff;
  readonly #events: QueueEvents;
  readonly #entries = new Map<number, Entry>();
  readonly #groups = new Set<Group>();
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

  constructor(source: Source, decoder: Decoder, backoff: Backoff, events: QueueEvents) {
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

  /** The last chunk that was to be asked for found no room. */
  get full(): boolean {
    return this.#refusedRoom;
  }

  /** Of the chunks that are needed, how many are damaged, and the first one's error. */
  get damaged(): { count: number; error: StreamError | undefined } {
    return this.#failed.needed;
  }

  /** What is damaged is asked for again now. */
  retry(): void {
    this.#failed.retryAll();
  }

  /** The chunks that are needed now and not resident, the most needed first; no others are. */
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
    this.#pumping.request();
  }

  /** Handles that are loading or decoding. */
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
  }

  #pump(): void {
    if (this.#closing.signal.aborted) return;
    if (this.#backoff.waiting) {
      this.#pumpWhenReady();
      return;
    }
    this.#refusedRoom = false;
    const free = this.#source.concurrency - this.#groups.size;
    if (free <= 0 || this.#decoding >= maxDecoding) return;
    const queued = [...this.#entries.values()]
      .filter(({ rank, state }) => rank < Number.POSITIVE_INFINITY && state === "queued")
      .sort((a, b) => a.rank - b.rank)
      .slice(0, chunksPlanned);
    if (queued.length === 0) return;
    for (const chunks of this.#groupsOf(queued).slice(0, free)) {
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
      // The others are in order. Its own answer says what is wrong.
      const broken = this.#entries.get(reason.handle);
      if (broken) broken.alone = true;
    } else if (first && group.entries.size === 1 && isOfPart(reason.kind)) {
      this.#refuse(first, reason);
    } else {
      for (const entry of group.entries) {
        if (++entry.tries >= maxTries) this.#fail(entry, reason);
      }
      // A browser may lose the end of an answer that broke off, and with it which chunk is broken.
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
      // Another worker has taken the place of one that was lost, mostly.
      if (++entry.tries > 1) this.#backoff.failed(reason);
    } else if (status === "malformed_chunk") {
      // What has the right checksum would not be another the next time.
      this.#fail(entry, reason);
    } else {
      this.#refuse(entry, reason);
    }
  }

  /** Bytes that are not the chunk's: once they are fetched again, past the caches. */
  #refuse(entry: Entry, error: StreamError): void {
    if (++entry.refused === 1) {
      this.#source.bypassCaches();
      entry.state = "queued";
    } else {
      this.#fail(entry, error);
    }
  }

  /** It is done without; its coarser level is shown. */
  #fail(entry: Entry, error: StreamError): void {
    const isFirst = this.#failed.needed.count === 0 && !entry.hasFailed;
    entry.state = "failed";
    entry.hasFailed = true;
    this.#failed.add(entry, error);
    this.#events.failed(error, isFirst);
  }
}

/** Not the source is at fault, but who decodes what it sends. */
function isOfDecoder(kind: FaultKind | undefined): boolean {
  return kind === "worker-lost" || kind === "out-of-memory";
}
