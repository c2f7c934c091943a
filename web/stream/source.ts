import { StreamError, type Triple } from "./types.ts";

/** A directory page's place in the store file. */
export interface PagePlace {
  index: number;
  offset: number;
  bytes: number;
}

/** A chunk's place in the store and in the store file. */
export interface ChunkPlaceInFile {
  /** Identifies the chunk in the directory and in the session. */
  handle: number;
  level: number;
  block: Triple;
  band: number;
  offset: number;
  bytes: number;
}

/**
 * A response of many chunks ended at one that the server cannot read; those before it are valid. A request
 * for the chunk's own URL returns the cause.
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
  /** Number of concurrent calls of `chunks` that is worth while. */
  readonly concurrency: number;
  /** Requests made and payload bytes received so far. */
  readonly requests: number;
  readonly bytesReceived: number;
  /**
   * Begins to fetch the header while the program itself is loading. If that fails, `header` rejects
   * with the reason. After `bypassCaches`, fetches the header at full length.
   */
  warm(): void;
  /**
   * The store's header: the first bytes of the file. `whole`: as many bytes as a header may have, for
   * when fewer were not enough.
   */
  header(signal: AbortSignal, whole?: boolean): Promise<Uint8Array>;
  /** A byte range of the file (pages, the coarse tail). `arrived` is called in order, as parts arrive. */
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
   * Many chunks. `arrived` is called for each complete chunk, in any order, before the promise
   * settles, and not afterwards. Rejects with a PartError if the server cannot read one of them.
   */
  chunks<C extends ChunkPlaceInFile>(
    chunks: readonly C[],
    signal: AbortSignal,
    arrived: (chunk: C, bytes: Uint8Array) => void,
  ): Promise<void>;
  /** From now on every request bypasses the caches: they hold wrong bytes. */
  bypassCaches(): void;
  /** Requests bypass the caches. */
  readonly fresh: boolean;
  /**
   * Fetches the content id (32 hex digits) of the store that is at the address now, past the caches.
   * It differs from the opened one if the volume was replaced. Rejects with the address's fault.
   */
  contentId(signal: AbortSignal): Promise<string>;
  /** Size of the file, if a response has stated it. */
  readonly fileBytes: number | undefined;
  /** Forgets the identity of the file. The next `header` may be that of another store. */
  forget(): void;
  /**
   * Divides needed chunks, in order of need, into groups for calls of `chunks`. The first group is
   * requested next. Groups are large if requests are costly.
   */
  group<C extends ChunkPlaceInFile>(chunks: readonly C[]): C[][];
}
