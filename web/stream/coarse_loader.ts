import { CoreError } from "../core/calls.ts";
import type { Store } from "../core/core.ts";
import type { Chunk } from "../core/records.ts";
import type { DecodedChunk } from "../core/types.ts";
import type { Backoff } from "./backoff.ts";
import { badDirectory, type CoarseChunk, CoarseTail } from "./coarse_tail.ts";
import type { Decoder } from "./decoder.ts";
import type { Source } from "./source.ts";
import { StreamError } from "./types.ts";

/** The requests of other sessions are paused for at most this time (ms), even if a chunk is not decoded. */
const longestPause = 1000;

export interface CoarseLoaderEvents {
  isResident(handle: number): boolean;
  /** A chunk is decoded. It stays resident as long as the volume is open. */
  decoded(chunk: Chunk, decoded: DecodedChunk): void;
  /** The bytes of the first surface have arrived (true), or nothing of it is left to be decoded (false). */
  decodingFirst(isDecoding: boolean): void;
  /** Resolves when everything decoded so far has been uploaded. */
  uploaded(): Promise<void>;
  /** Directory pages were added, the first surface is uploaded, or loading has ended. */
  changed(): void;
  failed(error: StreamError): void;
}

/**
 * Loads the coarse tail of the store for every isovalue, when a volume is opened. Chunks of the
 * first camera view's isovalues are decoded before the others.
 */
export class CoarseLoader {
  readonly #source: Source;
  readonly #store: Store;
  readonly #decoder: Decoder;
  readonly #events: CoarseLoaderEvents;
  readonly #tail: CoarseTail;
  readonly #decoding: Promise<void>[] = [];
  #finestLevel: number;
  #isLoading = true;
  #hasFirstSurface = false;
  #pause: ReturnType<typeof setTimeout> | undefined;

  /** `maxBytes`: StreamOptions.coarseBytes. */
  constructor(
    source: Source,
    store: Store,
    backoff: Backoff,
    decoder: Decoder,
    events: CoarseLoaderEvents,
    maxBytes?: number,
  ) {
    this.#source = source;
    this.#store = store;
    this.#decoder = decoder;
    this.#events = events;
    this.#tail = new CoarseTail(source, store, backoff, maxBytes);
    this.#finestLevel = this.#tail.finestLevel;
  }

  /** The finest level that is loaded for every isovalue. */
  get finestLevel(): number {
    return this.#finestLevel;
  }

  get isLoading(): boolean {
    return this.#isLoading;
  }

  /** The first surface is uploaded. Until then, nothing finer competes with it for bandwidth. */
  get hasFirstSurface(): boolean {
    return this.#hasFirstSurface;
  }

  /** Whether this loader is loading a level, so that no other part needs to request it. */
  isLoadingLevel(level: number): boolean {
    return this.#isLoading && level >= this.#finestLevel;
  }

  /** `sampleBudget` limits how many levels are loaded. Never rejects: see `failed`. */
  async load(
    sampleBudget: number,
    firstIsovalues: readonly number[],
    signal: AbortSignal,
  ): Promise<void> {
    const quantized = firstIsovalues.map((isovalue) => this.#store.quantizedIsovalue(isovalue));
    const isFirst = ({ chunk: { bandBegin, bandEnd } }: CoarseChunk): boolean =>
      quantized.some((isovalue) => bandBegin <= isovalue && isovalue < bandEnd);
    try {
      this.#finestLevel = await this.#tail.load(sampleBudget, signal, async (chunks) => {
        const decodeAll = (some: CoarseChunk[]): Promise<void>[] =>
          some.map((chunk) => {
            const decoding = this.#decode(chunk, signal);
            // The promise is awaited below. If loading fails earlier, its error is ignored.
            decoding.catch(() => {});
            return decoding;
          });
        if (!this.#hasFirstSurface) this.#pauseOthers();
        const first = decodeAll(chunks.filter(isFirst));
        const others = decodeAll(chunks.filter((chunk) => !isFirst(chunk)));
        this.#decoding.push(...first, ...others);
        this.#events.changed();
        await Promise.all(first);
        await this.#events.uploaded();
        this.#firstSurfaceUploaded();
      });
      await Promise.all(this.#decoding);
    } catch (error) {
      this.#resumeOthers();
      if (signal.aborted) return;
      this.#events.failed(errorOf(error));
    }
    // Chunks that are still missing have failed. From now on they are requested like any other chunk.
    this.#isLoading = false;
    this.#firstSurfaceUploaded();
  }

  #firstSurfaceUploaded(): void {
    this.#hasFirstSurface = true;
    this.#events.changed();
    // The selection that shows the surface, in a later task, comes before the requests of others.
    clearTimeout(this.#pause);
    this.#pause = setTimeout(() => this.#resumeOthers());
  }

  #pauseOthers(): void {
    this.#pause = setTimeout(() => this.#resumeOthers(), longestPause);
    this.#events.decodingFirst(true);
  }

  #resumeOthers(): void {
    clearTimeout(this.#pause);
    this.#events.decodingFirst(false);
  }

  async #decode({ chunk, bytes }: CoarseChunk, signal: AbortSignal): Promise<void> {
    if (this.#events.isResident(chunk.handle)) return;
    const decoded = await this.#decoder.decode(chunk, bytes, signal).catch((error: unknown) => {
      // The chunk is requested again, and its fault reported, when the selection needs it.
      if (!(error instanceof CoreError)) throw error;
      if (error.status === "checksum_mismatch") this.#source.bypassCaches();
    });
    if (decoded) this.#events.decoded(chunk, decoded);
  }
}

function errorOf(error: unknown): StreamError {
  if (error instanceof StreamError) return error;
  if (error instanceof CoreError) return badDirectory(error);
  return new StreamError("internal", `the coarse levels: ${String(error)}`, error);
}
