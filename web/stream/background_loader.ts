import { CoreError } from "../core/calls.ts";
import type { Store } from "../core/core.ts";
import type { Chunk } from "../core/records.ts";
import type { DecodedChunk } from "../core/types.ts";
import type { Decoder } from "./decoder.ts";
import {
  addPages,
  bandDistance,
  damagedChunk,
  fetchInGroups,
  missingPages,
  type Preparation,
} from "./fetch_ahead.ts";
import { IdleWork } from "./idle_work.ts";
import type { Source } from "./source.ts";

/** The default limit of bytes, and the largest share of the store. */
const maxBytes = 4e6;
/**
 * Level 1 and all coarser levels of engine, bonsai, aneurysm and chris_t1 take 0.20 to 0.30 of their
 * stores.
 */
const maxShare = 0.3;

export interface BackgroundLoaderEvents {
  /** Whether a chunk is resident, so that it need not be fetched. */
  isResident(handle: number): boolean;
  /** Reserves memory that nothing else needs. Returns false if there is none. */
  admit(chunk: Chunk): boolean;
  /** An admitted chunk will not be decoded. */
  released(chunk: Chunk): void;
  decoded(chunk: Chunk, decoded: DecodedChunk): void;
  /** Resolves when everything decoded so far has been uploaded. */
  uploaded(): Promise<void>;
  /** `preparation` has changed, or a chunk for which `isArriving` was true is damaged. */
  changed(): void;
  /** All chunks that fit are resident. Called once. */
  ended(): void;
}

/** The default limit of bytes to fetch, for a store of this size. */
export function defaultBackgroundBytes(fileBytes: number): number {
  return Math.min(maxBytes, maxShare * fileBytes);
}

/** Whether the browser's data saver is on (the Save-Data client hint). */
export function savesData(): boolean {
  if (typeof navigator === "undefined") return false;
  const { connection } = navigator as { connection?: { saveData?: boolean } };
  return connection?.saveData === true;
}

/**
 * Fetches coarse levels for every isovalue while a view is complete, so that a moving isovalue finds
 * fine cells without a request. It fetches the levels finer than those of the CoarseLoader, except
 * level 0: the coarsest level first, and within a level the bands nearest to the present isovalues
 * first. A fault ends loading silently: a view that needs the same chunk requests it again, and reports
 * the fault.
 */
export class BackgroundLoader {
  readonly #source: Source;
  readonly #store: Store;
  readonly #decoder: Decoder;
  readonly #budget: number;
  readonly #events: BackgroundLoaderEvents;
  /** Chunks that were fetched or are damaged. Each chunk is fetched only once. */
  readonly #seen = new Set<number>();
  /** Chunks being decoded, by handle. */
  readonly #decoding = new Map<number, Promise<void>>();
  readonly #closing = new AbortController();
  readonly #work = new IdleWork(() => {
    if (this.#isDone) this.#events.ended();
    this.#events.changed();
  });
  #bytes = 0;
  #bytesPlanned = 0;
  #isDone: boolean;

  /** `budget`: limit of bytes to fetch while the volume is open, including directory pages. */
  constructor(
    source: Source,
    store: Store,
    decoder: Decoder,
    budget: number,
    events: BackgroundLoaderEvents,
  ) {
    this.#source = source;
    this.#store = store;
    this.#decoder = decoder;
    this.#budget = budget;
    this.#events = events;
    this.#isDone = !(budget > 0);
    this.#bytesPlanned = budget;
  }

  /**
   * The state of loading. Null if nothing is being fetched, and nothing will be before another
   * `start`.
   */
  get preparation(): Preparation | null {
    if (!this.#work.isRunning) return null;
    return { bytes: this.#bytes, bytesPlanned: this.#bytesPlanned };
  }

  /** Nothing is left to be fetched. */
  get isDone(): boolean {
    return this.#isDone;
  }

  /** All chunks that the budget and memory allow are resident. */
  get isPrepared(): boolean {
    return this.#isDone && this.#budget > 0;
  }

  /** Whether the chunk's bytes have arrived, so that it needs no other request. */
  isArriving(handle: number): boolean {
    return this.#decoding.has(handle);
  }

  /**
   * A view of these isovalues is complete. `finestLoaded`: the finest level whose chunks are all
   * resident.
   */
  start(isovalues: readonly number[], finestLoaded: number): void {
    if (this.#isDone) return;
    const quantized = isovalues.map((isovalue) => this.#store.quantizedIsovalue(isovalue));
    this.#work.start((signal) => this.#run(quantized, finestLoaded - 1, signal));
  }

  /** A view needs other chunks. Cancels requests; chunks that have arrived are still decoded. */
  stop(): void {
    this.#work.stop();
  }

  /** The volume is closed. No event follows. */
  close(): void {
    this.#isDone = true;
    this.#work.close();
    this.#closing.abort(new DOMException("the volume was closed", "AbortError"));
  }

  async #run(isovalues: readonly number[], finest: number, signal: AbortSignal): Promise<void> {
    for (let level = finest; level > 0; --level) {
      if (!(await this.#addPages(level, signal))) break;
      this.#plan(level);
      const missing = this.#missing(level);
      const affordable = this.#affordable(byDistance(missing, isovalues));
      if (!(await this.#fetchAll(affordable, signal))) break;
      if (affordable.length < missing.length) break;
    }
    await Promise.all(this.#decoding.values());
    await this.#events.uploaded();
    signal.throwIfAborted();
    this.#isDone = true;
  }

  /** Returns false if the budget does not suffice. */
  async #addPages(level: number, signal: AbortSignal): Promise<boolean> {
    const pages = missingPages(this.#store, level);
    if (pages.length === 0) return true;
    const bytes = pages.reduce((sum, page) => sum + page.bytes, 0);
    if (this.#bytes + bytes > this.#budget) return false;
    await addPages(this.#source, this.#store, pages, signal);
    this.#bytes += bytes;
    return true;
  }

  /** Chunks of the level that are neither resident nor were fetched before. */
  #missing(level: number): Chunk[] {
    return this.#store
      .chunksFor(level, ...this.#store.info.range)
      .filter(({ handle }) => !this.#seen.has(handle) && !this.#events.isResident(handle));
  }

  /** The first chunks, as far as the budget suffices. */
  #affordable(chunks: readonly Chunk[]): Chunk[] {
    let bytes = this.#bytes;
    const tooLarge = chunks.findIndex((chunk) => {
      bytes += chunk.bytes;
      return bytes > this.#budget;
    });
    return tooLarge < 0 ? [...chunks] : chunks.slice(0, tooLarge);
  }

  /** Returns false if memory does not suffice. */
  #fetchAll(chunks: readonly Chunk[], signal: AbortSignal): Promise<boolean> {
    const isFetched = ({ handle }: Chunk): boolean => this.#seen.has(handle);
    return fetchInGroups(this.#source, chunks, isFetched, async (group) => {
      const admitted = group.filter((chunk) => this.#events.admit(chunk));
      if (admitted.length > 0) await this.#fetch(admitted, signal);
      return admitted.length === group.length;
    });
  }

  async #fetch(chunks: readonly Chunk[], signal: AbortSignal): Promise<void> {
    const underway = new Set(chunks);
    try {
      await this.#source.chunks(chunks, signal, (chunk, bytes) => {
        underway.delete(chunk);
        this.#bytes += chunk.bytes;
        this.#seen.add(chunk.handle);
        this.#decoding.set(chunk.handle, this.#decode(chunk, bytes));
      });
    } catch (error) {
      this.#seen.add(damagedChunk(chunks, error));
    } finally {
      for (const chunk of underway) this.#events.released(chunk);
    }
  }

  async #decode(chunk: Chunk, bytes: Uint8Array): Promise<void> {
    const { signal } = this.#closing;
    try {
      const decoded = await this.#decoder.decode(chunk, bytes, signal);
      this.#decoding.delete(chunk.handle);
      if (!signal.aborted) this.#events.decoded(chunk, decoded);
    } catch (error) {
      this.#decoding.delete(chunk.handle);
      if (signal.aborted) return;
      this.#events.released(chunk);
      // The caches may hold the wrong bytes.
      if (error instanceof CoreError && error.status === "checksum_mismatch") {
        this.#source.bypassCaches();
      }
    }
    this.#events.changed();
  }

  /**
   * Computes the bytes to fetch in all. If directory pages are missing, it assumes the whole
   * budget.
   */
  #plan(level: number): void {
    let bytes = this.#bytes;
    for (let l = level; l > 0; --l) {
      if (missingPages(this.#store, l).length > 0) {
        bytes = this.#budget;
        break;
      }
      bytes += this.#missing(l).reduce((sum, chunk) => sum + chunk.bytes, 0);
    }
    this.#bytesPlanned = Math.min(this.#budget, bytes);
    this.#events.changed();
  }
}

/** Orders chunks by the distance of their bands from the nearest isovalue. */
function byDistance(chunks: readonly Chunk[], isovalues: readonly number[]): Chunk[] {
  const distance = (chunk: Chunk): number =>
    Math.min(...isovalues.map((isovalue) => Math.abs(bandDistance(chunk, isovalue))));
  return [...chunks].sort((a, b) => distance(a) - distance(b));
}
