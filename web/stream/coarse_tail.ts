import { CoreError } from "../core/calls.ts";
import type { CoarseRange, Store } from "../core/core.ts";
import type { Chunk } from "../core/records.ts";
import type { Backoff } from "./backoff.ts";
import type { Source } from "./source.ts";
import { measured } from "./timeline.ts";
import { joined } from "./transfer.ts";
import { StreamError } from "./types.ts";

/** The default limit of bytes loaded for every isovalue, so that a moving slider always has a surface. */
export const defaultCoarseBytes = 160 * 1024;
/** The coarse levels may take this share of the samples that the budget allows. */
const budgetShare = 1 / 3;

/** A chunk of the coarse tail with its bytes. */
export interface CoarseChunk {
  chunk: Chunk;
  bytes: Uint8Array;
}

/**
 * Fetches the coarse tail of the store for every isovalue: first the coarsest levels, in one
 * request, then the finer levels that fit. In the file, finer chunks precede coarser chunks, and
 * the pages of finer levels follow those of coarser levels. So the second step fetches one range
 * before the first range and one after it.
 */
export class CoarseTail {
  readonly #source: Source;
  readonly #store: Store;
  readonly #backoff: Backoff;
  readonly #maxBytes: number;
  /** The levels that are fetched first. */
  readonly #first: CoarseRange;

  /** `maxBytes`: StreamOptions.coarseBytes. */
  constructor(source: Source, store: Store, backoff: Backoff, maxBytes = defaultCoarseBytes) {
    this.#source = source;
    this.#store = store;
    this.#backoff = backoff;
    this.#maxBytes = maxBytes;
    this.#first = firstRange(source, store);
  }

  /** The levels that `load` may fetch. */
  #range(): CoarseRange {
    const all = this.#store.coarseRange(this.#maxBytes);
    return all.firstLevel < this.#first.firstLevel ? all : this.#first;
  }

  /** The finest level that `load` may fetch. */
  get finestLevel(): number {
    return this.#range().firstLevel;
  }

  /**
   * `arrived` is called at most twice: first with the chunks of the coarsest levels, then with the
   * others. The others are requested after the promise of the first call has resolved.
   * `sampleBudget` limits how many levels are fetched. Resolves with the finest fetched level.
   */
  async load(
    sampleBudget: number,
    signal: AbortSignal,
    arrived: (chunks: CoarseChunk[]) => Promise<void>,
  ): Promise<number> {
    const first = this.#first;
    const firstEnd = first.offset + first.bytes;
    const firstPart = await this.#fetch(first.offset, first.bytes, signal);
    const coarsest = this.#chunks(first.firstLevel, this.#store.info.levels, firstPart);
    await arrived(coarsest);
    const all = this.#range();
    if (all.firstLevel >= first.firstLevel) return first.firstLevel;

    // The pages state the number of samples of a level, which shows whether it fits into the budget.
    const missing = all.offset + all.bytes - firstEnd;
    if (missing > 0) this.#addPages(await this.#fetch(firstEnd, missing, signal));
    let samples = countSamples(coarsest.map(({ chunk }) => chunk));
    let finest = first.firstLevel;
    while (finest > all.firstLevel) {
      const chunks = this.#chunksOf(finest - 1);
      if (!chunks) break;
      samples += countSamples(chunks);
      if (samples > sampleBudget * budgetShare) break;
      --finest;
    }
    if (finest === first.firstLevel) return finest;
    const from = Math.min(
      ...(this.#chunksOf(finest) ?? []).map((chunk) => chunk.offset),
      first.offset,
    );
    if (from < first.offset) {
      const part = await this.#fetch(from, first.offset - from, signal);
      await arrived(this.#chunks(finest, first.firstLevel, part));
    }
    return finest;
  }

  /** Fetches a byte range. After a fault, only the missing bytes are fetched again. */
  async #fetch(offset: number, bytes: number, signal: AbortSignal): Promise<Part> {
    const parts: Uint8Array[] = [];
    let have = 0;
    if (bytes > 0) {
      await this.#backoff.retry(
        signal,
        () =>
          this.#source.range(offset + have, bytes - have, signal, (part) => {
            parts.push(part);
            have += part.length;
          }),
        { slowly: true },
      );
    }
    return { offset, bytes: joined(parts) };
  }

  #everyIsovalue(): [number, number] {
    const [low, high] = this.#store.info.range;
    return [low, high];
  }

  /** Adds the pages that lie in the part. */
  #addPages(part: Part): void {
    measured("isosplat:streaming", () => this.#addPagesOf(part));
  }

  #addPagesOf(part: Part): void {
    for (const page of this.#store.pages()) {
      const at = page.offset - part.offset;
      if (page.resident || at < 0 || at + page.bytes > part.bytes.length) continue;
      try {
        this.#store.addPage(page.index, part.bytes.subarray(at, at + page.bytes));
      } catch (error) {
        // PageLoader fetches a damaged page again, and reports it, when the view needs it.
        if (!(error instanceof CoreError)) throw error;
        this.#source.bypassCaches();
      }
    }
  }

  /** Undefined if a page of the level is missing or damaged. */
  #chunksOf(level: number): Chunk[] | undefined {
    if (this.#store.missingPages(level, ...this.#everyIsovalue()).length > 0) return undefined;
    return this.#store.chunksFor(level, ...this.#everyIsovalue());
  }

  /** The chunks of levels [from, to) that lie in the part, the coarsest first. */
  #chunks(from: number, to: number, part: Part): CoarseChunk[] {
    this.#addPages(part);
    const result: CoarseChunk[] = [];
    for (let level = to - 1; level >= from; --level) {
      for (const chunk of this.#chunksOf(level) ?? []) {
        const at = chunk.offset - part.offset;
        if (at < 0 || at + chunk.bytes > part.bytes.length) continue;
        result.push({ chunk, bytes: part.bytes.slice(at, at + chunk.bytes) });
      }
    }
    return result;
  }
}

interface Part {
  offset: number;
  bytes: Uint8Array;
}

/**
 * The range of the coarse levels that `ready` contains completely. Returns the bootstrap range if
 * `ready` contains no whole level, and also if it contains the whole bootstrap range.
 */
function firstRange({ ready }: Source, store: Store): CoarseRange {
  const bootstrap = store.bootstrapRange();
  if (!ready || ready.offset <= bootstrap.offset) return bootstrap;
  const end = ready.offset + ready.bytes;
  for (let most = ready.bytes; most >= 1; most /= 2) {
    const { firstLevel, offset, bytes } = store.coarseRange(most);
    const isReady = offset >= ready.offset && offset + bytes <= end;
    if (isReady) return { firstLevel, offset, bytes: end - offset };
  }
  return bootstrap;
}

function countSamples(chunks: readonly Chunk[]): number {
  return chunks.reduce((samples, chunk) => samples + chunk.cells, 0);
}

/** Makes the error of a directory that does not match the header. */
export function badDirectory(error: unknown): StreamError {
  const message = error instanceof Error ? error.message : String(error);
  return new StreamError(
    "damaged-page",
    `the store's directory cannot be read: ${message}. Rebuild the store, or copy it again`,
    error,
  );
}
