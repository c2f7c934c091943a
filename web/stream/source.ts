import type { StoreInfo, Triple } from "../core/types.ts";
import { StreamError } from "./types.ts";

/** The byte range of a directory page in the store file. */
export interface PagePlace {
  index: number;
  offset: number;
  bytes: number;
}

/** The position of a chunk in the volume, and its byte range in the store file. */
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
 * A response of many chunks ended at a chunk that the server cannot read; the chunks before it are
 * valid. A request for this chunk alone returns the cause.
 */
export class PartError extends StreamError {
  readonly handle: number;
  constructor(handle: number, message: string) {
    super("damaged-part", message);
    this.handle = handle;
  }
}

/** A byte range of the store file. */
export interface FileRange {
  offset: number;
  bytes: number;
}

/**
 * The source of a store's bytes. It neither retries nor verifies content. It returns the requested
 * bytes, or rejects with a StreamError (or the signal's reason).
 */
export interface Source {
  /** For messages: the URL or the volume's name. */
  readonly name: string;
  /**
   * The absolute address by which a scene can name the store (shared/core/scene/SCENE.md). Undefined if it has
   * none, like a file of this device.
   */
  readonly address?: string | undefined;
  /**
   * The part of the coarse tail that needs no separate request once the header is known, or undefined. The first
   * surface is drawn from it before more is fetched.
   */
  readonly ready?: FileRange | undefined;
  /**
   * The distances between voxels (mm) that replace those of the header, for a volume whose file stated none.
   * Undefined, as its result: those of the header.
   */
  spacingOf?: ((info: StoreInfo) => Triple | undefined) | undefined;
  /** Whether the bytes are on this device, so that reading them needs no connection. */
  readonly isLocal?: boolean;
  /** The useful number of concurrent calls of `chunks`. */
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
   * The store's header: the first bytes of the file. `whole`: fetches the largest possible size of a
   * header, if fewer bytes were not enough.
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
  /**
   * From now on every request bypasses the caches, because they hold wrong bytes. Called for each part whose
   * bytes are wrong.
   */
  bypassCaches(): void;
  /** Requests bypass the caches. */
  readonly fresh: boolean;
  /**
   * Fetches the content id (32 hex digits) of the store that is at the address now, bypassing the
   * caches. It differs from that of the opened store if the volume was replaced. Rejects with the fault
   * of the address.
   */
  contentId(signal: AbortSignal): Promise<string>;
  /** Size of the file, if a response has stated it. */
  readonly fileBytes: number | undefined;
  /** Forgets the identity of the file. The next `header` may be that of another store. */
  forget(): void;
  /**
   * Divides needed chunks, in order of need, into groups for calls of `chunks`. The first group is
   * requested next. Groups are large if requests are expensive.
   */
  group<C extends ChunkPlaceInFile>(chunks: readonly C[]): C[][];
}
