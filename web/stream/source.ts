import { StreamError, type Triple } from "./types.ts";

/** A directory page's place in the store file. */
export interface PagePlace {
  index: number;
  offset: number;
  bytes: number;
}

/** A chunk's place in the store and in the store file. */
export interface ChunkPlaceInFile {
  /** Of the directory: what the session knows the chunk by. */
  handle: number;
  level: number;
  block: Triple;
  band: number;
  offset: number;
  bytes: number;
}

/**
 * An answer of many chunks broke off at one that the server cannot read. The others are in order;
 * the chunk's own URL says what is wrong with it.
 */
export class PartError extends StreamError {
  readonly handle: number;
  constructor(handle: number, message: string) {
    super("damaged-part", message);
    this.handle = handle;
  }
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
  /**
   * Begins to fetch what `header` will be asked for: for while the program itself is loading. Should
   * that fail, `header` rejects with the reason. As a whole once the caches are distrusted.
   */
  warm(): void;
  /**
   * The store's header: the first bytes of the file. `whole`: as many as a header may have, where fewer
   * turned out too few.
   */
  header(signal: AbortSignal, whole?: boolean): Promise<Uint8Array>;
  /** A range of the file, handed on in order as it arrives (pages, the coarse tail). */
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
   * Many chunks; each is handed on as soon as it is whole, in any order, before this settles. When
   * it rejects, those not handed on do not arrive any more. Rejects with a PartError where one of
   * them cannot be read and the others may be.
   */
  chunks<C extends ChunkPlaceInFile>(
    chunks: readonly C[],
    signal: AbortSignal,
    arrived: (chunk: C, bytes: Uint8Array) => void,
  ): Promise<void>;
  /** From now on every request goes past the caches: they hold wrong bytes. */
  bypassCaches(): void;
  /** The caches are distrusted. */
  readonly fresh: boolean;
  /**
   * The content id (32 hex digits) of the store that is at the address now, past the caches. Not
   * that which was opened: the volume was replaced. Rejects with what is wrong with it otherwise.
   */
  contentId(signal: AbortSignal): Promise<string>;
  /** Bytes of the whole file, where the source has been told. */
  readonly fileBytes: number | undefined;
  /** The next `header` is of what is at the address then, whatever it was before. */
  forget(): void;
  /**
   * How to cut a list of wanted chunks, in order of need, into calls of `chunks`: the first group
   * is asked for next. A source that pays by request makes groups large.
   */
  group<C extends ChunkPlaceInFile>(chunks: readonly C[]): C[][];
}
