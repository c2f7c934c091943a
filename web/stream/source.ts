import type { Triple } from "./types.ts";

/** A directory page's place in the store file. */
export interface PagePlace {
  index: number;
  offset: number;
  bytes: number;
}

/** A chunk's place in the store and in the store file. */
export interface ChunkPlaceInFile {
  level: number;
  block: Triple;
  slab: number;
  offset: number;
  bytes: number;
}

/**
 * Where a store's bytes come from. A source neither retries nor checks content: it turns requests
 * into bytes, or rejects with a StreamError (or the signal's reason).
 */
export interface Source {
  /** For messages: the URL or the volume's name. */
  readonly name: string;
  /** Most calls of `chunks` that are worth having under way at a time. */
  readonly concurrency: number;
  /** Requests made and payload bytes received so far. */
  readonly requests: number;
  readonly bytesReceived: number;
  /** Begins to fetch what `head` will be asked for: for while the program itself is loading. */
  warm(): void;
  /**
   * The store's head: the first bytes of the file. `whole`: as many as a head may have, where fewer
   * turned out too few.
   */
  head(signal: AbortSignal, whole?: boolean): Promise<Uint8Array>;
  /** A stretch of the file, handed on in order as it arrives (pages, the coarse end). */
  range(
    offset: number,
    bytes: number,
    signal: AbortSignal,
    arrived: (part: Uint8Array, offset: number) => void,
  ): Promise<void>;
  pages(
    pages: readonly PagePlace[],
    signal: AbortSignal,
    arrived: (index: number, bytes: Uint8Array) => void,
  ): Promise<void>;
  /**
   * Many chunks; each is handed on as soon as it is whole, in any order. When this rejects, those
   * not handed on have not arrived.
   */
  chunks<C extends ChunkPlaceInFile>(
    chunks: readonly C[],
    signal: AbortSignal,
    arrived: (chunk: C, bytes: Uint8Array) => void,
  ): Promise<void>;
  /** From now on every request goes past the caches: they hold wrong bytes. */
  distrustCaches(): void;
  /**
   * How to cut a list of wanted chunks, in order of need, into calls of `chunks`: the first group
   * is asked for next. A source that pays by request makes groups large.
   */
  group<C extends ChunkPlaceInFile>(chunks: readonly C[]): C[][];
}
