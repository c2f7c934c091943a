import { type Chunk, CoreError } from "../core/index.ts";
import type { Backoff } from "./backoff.ts";
import type { Decoder } from "./decoder.ts";
import { OwnTask } from "./own_task.ts";
import type { Source } from "./source.ts";
import { measured } from "./timeline.ts";
import { StreamError } from "./types.ts";

/** See README.md. A chunk that the queue does not know is `known` or `resident`. */
export type ChunkState = "queued" | "loading" | "decoding" | "failed";

/** Chunks that have arrived and wait for a worker: beyond this, nothing more is asked for. */
const mostDecoding = 64;
/** Of this many of the most needed chunks the next requests are made. */
const chunksPlanned = 256;
/** A volume that is not there any more is asked for again after so long (ms). */
const missingPause = 30_000;

interface Entry {
  chunk: Chunk;
  state: ChunkState;
  /** 0: most needed. Infinity: no longer needed. */
  rank: number;
  /** Times that its bytes were not what the directory states. */
  refused: number;
  /** A failed entry that may be there after the pause. */
  comesBack: boolean;
}

interface Group {
  entries: Set<Entry>;
  abort: AbortController;
}

export interface QueueEvents {
  /** Whether there is room for the chunk; called before it is asked for, and reserves it. */
  admit(chunk: Chunk): boolean;
  /** The chunk is decoded; it leaves the queue. */
  decoded(chunk: Chunk, samples: Uint32Array): void;
  /** An admitted chunk does not come after all. */
  released(chunk: Chunk): void;
  error(error: StreamError): void;
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
  readonly #pumping = new OwnTask(() => measured("isosplat:streaming", () => this.#pump()));
  #decoding = 0;
  #waking = false;
  #refusedRoom = false;

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

  /** The chunks that are needed now and not resident, the most needed first; no others are. */
  need(chunks: readonly Chunk[]): void {
    for (const entry of this.#entries.values()) entry.rank = Number.POSITIVE_INFINITY;
    chunks.forEach((chunk, rank) => {
      const entry = this.#entries.get(chunk.handle);
      if (entry) entry.rank = rank;
      else {
        const fresh: Entry = { chunk, state: "queued", rank, refused: 0, comesBack: false };
        this.#entries.set(chunk.handle, fresh);
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
    if (free <= 0 || this.#decoding >= mostDecoding) return;
    const queued = [...this.#entries.values()]
      .filter((entry) => this.#mayAsk(entry))
      .sort((a, b) => a.rank - b.rank)
      .slice(0, chunksPlanned);
    if (queued.length === 0) return;
    const groups = this.#source.group(queued.map((entry) => entry.chunk));
    for (const chunks of groups.slice(0, free)) {
      const admitted = chunks.filter((chunk) => this.#events.admit(chunk));
      if (admitted.length > 0) void this.#load(admitted);
      if (admitted.length < chunks.length) {
        this.#refusedRoom = true;
        break;
      }
    }
  }

  #mayAsk(entry: Entry): boolean {
    if (entry.rank === Number.POSITIVE_INFINITY) return false;
    if (entry.state === "failed" && entry.comesBack) entry.state = "queued";
    return entry.state === "queued";
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
    this.#events.changed();
    try {
      await this.#source.chunks(chunks, group.abort.signal, (chunk, bytes) => {
        const entry = this.#entries.get(chunk.handle);
        if (!entry || !group.entries.delete(entry)) return;
        this.#backoff.succeeded();
        void this.#decode(entry, bytes);
      });
      if (group.entries.size > 0) throw new StreamError("internal", "the source left chunks out");
    } catch (error) {
      this.#loadFailed(group, error);
    } finally {
      this.#groups.delete(group);
      if (!this.#closing.signal.aborted) {
        this.#events.changed();
        this.#pumping.request();
      }
    }
  }

  #loadFailed(group: Group, error: unknown): void {
    const wasAborted = group.abort.signal.aborted;
    const reason =
      error instanceof StreamError
        ? error
        : new StreamError("internal", String(error), false, error);
    for (const entry of group.entries) {
      this.#events.released(entry.chunk);
      entry.state = "queued";
      if (wasAborted) {
        if (entry.rank === Number.POSITIVE_INFINITY) this.#entries.delete(entry.chunk.handle);
      } else if (!reason.retrying) {
        entry.state = "failed";
        entry.comesBack = true;
      }
    }
    if (wasAborted || this.#closing.signal.aborted) return;
    if (reason.retrying) {
      this.#backoff.failed(reason);
    } else {
      // Others would meet the same fate: nothing is asked for until the pause is over. What was
      // under way beside it is part of the same failure.
      const isFirst = !this.#backoff.waiting;
      this.#backoff.pause(missingPause);
      if (isFirst) this.#events.error(reason);
    }
  }

  async #decode(entry: Entry, bytes: Uint8Array): Promise<void> {
    entry.state = "decoding";
    ++this.#decoding;
    try {
      const samples = await this.#decoder.decode(entry.chunk, bytes, this.#closing.signal);
      if (this.#closing.signal.aborted) return;
      this.#entries.delete(entry.chunk.handle);
      this.#events.decoded(entry.chunk, samples);
    } catch (error) {
      if (this.#closing.signal.aborted) return;
      this.#events.released(entry.chunk);
      this.#refuse(entry, error);
    } finally {
      --this.#decoding;
      if (!this.#closing.signal.aborted) {
        this.#events.changed();
        this.#pumping.request();
      }
    }
  }

  /** Bytes that do not decode: once they are fetched again, past the caches; then it is reported. */
  #refuse(entry: Entry, error: unknown): void {
    const { level, block, slab } = entry.chunk;
    const name = `chunk ${level}/${block.join(".")}/${slab}`;
    const status = error instanceof CoreError ? error.status : "internal";
    ++entry.refused;
    if (entry.refused === 1 && status !== "malformed_chunk") {
      if (status === "checksum_mismatch") this.#source.distrustCaches();
      entry.state = "queued";
      return;
    }
    entry.state = "failed";
    entry.comesBack = false;
    const message = error instanceof Error ? error.message : String(error);
    this.#events.error(
      new StreamError(
        status === "internal" ? "internal" : "corrupt",
        `${name}: ${message}. Its coarser level is shown instead; rebuild the store, or copy it again`,
        false,
        error,
      ),
    );
  }
}
