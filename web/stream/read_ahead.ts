import type { Store } from "../core/core.ts";
import type { Chunk } from "../core/records.ts";
import { defaultCoarseBytes } from "./coarse_tail.ts";
import {
  addPages,
  bandDistance,
  damagedChunk,
  fetchInGroups,
  missingPages,
  type Preparation,
} from "./fetch_ahead.ts";
import { IdleWork } from "./idle_work.ts";
import { KeptBytes } from "./kept_bytes.ts";
import { KeptSource } from "./kept_source.ts";
import type { Source } from "./source.ts";

/** The default of `StreamOptions.readAheadBytes`. */
export const defaultReadAheadBytes = 16e6;
/** Bands against the direction of the last movement count as this many times as far away. */
const behind = 2;

export interface ReadAheadEvents {
  /** `preparation` has changed. */
  changed(): void;
  /** The whole store is kept, except for damaged parts. Called once. */
  ended(): void;
}

/**
 * The source that a session reads through. It keeps all bytes if the store has at most `maxBytes`, and
 * otherwise the coarse tail, so that another session can show the store from afar without requests. With 0, and
 * for a store on this device, nothing is kept.
 */
export function keptSource(source: Source, store: Store, maxBytes = defaultReadAheadBytes): Source {
  const { fileBytes } = store.info;
  if (source.isLocal || source instanceof KeptSource || maxBytes === 0) return source;
  if (fileBytes > maxBytes) {
    const coarse = store.bootstrapRange().bytes + defaultCoarseBytes;
    return new KeptSource(source, new KeptBytes(coarse), { keepsParts: false });
  }
  // A part of the coarse tail may be kept twice, because it was also fetched as a chunk.
  return new KeptSource(source, new KeptBytes(2 * fileBytes));
}

/**
 * Reads a small store as a whole while a view is complete, so that another isovalue makes no request. The
 * chunks stay encoded in memory until a view needs them. The bands nearest to the present isovalues come
 * first, and those in the direction of the last movement before those behind. Faults are not reported: see
 * IdleWork.
 */
export class ReadAhead {
  readonly #source: KeptSource | undefined;
  readonly #store: Store;
  readonly #events: ReadAheadEvents;
  readonly #work: IdleWork;
  readonly #damaged = new Set<number>();
  #bytes = 0;
  #bytesPlanned: number;
  #isDone = false;

  /** Nothing is read ahead, unless `source` keeps its bytes (`keptSource`). */
  constructor(source: Source, store: Store, isEnabled: boolean, events: ReadAheadEvents) {
    this.#source = isEnabled && source instanceof KeptSource ? source : undefined;
    this.#store = store;
    this.#events = events;
    // More exactly once the directory is known.
    this.#bytesPlanned = store.info.fileBytes;
    this.#work = new IdleWork(() => {
      if (this.#isDone) events.ended();
      events.changed();
    });
  }

  /** See BackgroundLoader.preparation. */
  get preparation(): Preparation | null {
    if (!this.#work.isRunning) return null;
    return { bytes: this.#bytes, bytesPlanned: this.#bytesPlanned };
  }

  /**
   * A view of these isovalues is complete. `direction`: of their last change, −1 or 1, or 0 if they have not
   * changed. Does nothing once caches or the source have returned wrong bytes.
   */
  start(isovalues: readonly number[], direction: number): void {
    const source = this.#source;
    if (!source || this.#isDone || source.fresh) return;
    const quantized = isovalues.map((isovalue) => this.#store.quantizedIsovalue(isovalue));
    this.#work.start((signal) => this.#run(source, quantized, direction, signal));
  }

  /** A view needs other chunks. Cancels requests. */
  stop(): void {
    this.#work.stop();
  }

  /** The volume is closed. No event follows. */
  close(): void {
    this.#work.close();
  }

  async #run(
    source: KeptSource,
    isovalues: readonly number[],
    direction: number,
    signal: AbortSignal,
  ): Promise<void> {
    for (let level = this.#store.info.levels - 1; level >= 0; --level) {
      const pages = missingPages(this.#store, level);
      if (pages.length > 0) await addPages(source, this.#store, pages, signal);
    }
    const isFetched = (chunk: Chunk): boolean =>
      this.#damaged.has(chunk.handle) || source.has(chunk);
    const missing = this.#chunks().filter((chunk) => !isFetched(chunk));
    this.#bytesPlanned = this.#bytes + missing.reduce((sum, { bytes }) => sum + bytes, 0);
    this.#events.changed();
    const ordered = inOrderOfNeed(missing, isovalues, direction);
    await fetchInGroups(source, ordered, isFetched, async (group) => {
      try {
        await source.chunks(group, signal, ({ bytes }) => {
          this.#bytes += bytes;
        });
      } catch (error) {
        this.#damaged.add(damagedChunk(group, error));
      }
      this.#events.changed();
      return true;
    });
    signal.throwIfAborted();
    this.#isDone = true;
  }

  #chunks(): Chunk[] {
    const { levels, range } = this.#store.info;
    return Array.from({ length: levels }, (_, level) =>
      this.#store.chunksFor(level, ...range),
    ).flat();
  }
}

/** Orders chunks by the distance of their bands from the nearest isovalue; the coarsest level first. */
function inOrderOfNeed(
  chunks: readonly Chunk[],
  isovalues: readonly number[],
  direction: number,
): Chunk[] {
  const need = (chunk: Chunk): number =>
    Math.min(
      ...isovalues.map((isovalue) => {
        const distance = bandDistance(chunk, isovalue);
        return Math.abs(distance) * (distance * direction < 0 ? behind : 1);
      }),
    );
  return chunks
    .map((chunk) => ({ chunk, need: need(chunk) }))
    .sort((a, b) => a.need - b.need || b.chunk.level - a.chunk.level)
    .map(({ chunk }) => chunk);
}
