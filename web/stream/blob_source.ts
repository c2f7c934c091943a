import { maxHeaderBytes } from "../core/core.ts";
import { contentIdOf } from "./file_source.ts";
import { ranges } from "./range_source.ts";
import type { ChunkPlaceInFile, PagePlace, Source } from "./source.ts";
import { beginsAsStore } from "./transfer.ts";
import { StreamError } from "./types.ts";

/** The members of a Blob by which a file is read. */
export interface SlicedFile {
  /** In bytes. */
  readonly size: number;
  slice(start: number, end: number): { arrayBuffer(): Promise<ArrayBuffer> };
}

/**
 * A store on this device: a file that the user chose, or a store that was just built. It is not
 * uploaded. If the file is changed, moved or removed while it is open, reading fails with the fault
 * `unreachable`.
 */
export class BlobSource implements Source {
  readonly name: string;
  readonly concurrency = 2;
  readonly fresh = false;
  readonly isLocal: boolean;
  readonly #blob: SlicedFile;
  #requests = 0;
  #bytesReceived = 0;

  /** `name`: for messages; the name of the file, for example. `isLocal`: false if reading needs a connection. */
  constructor(blob: SlicedFile, name: string, isLocal = true) {
    this.#blob = blob;
    this.name = name;
    this.isLocal = isLocal;
  }

  get requests(): number {
    return this.#requests;
  }

  get bytesReceived(): number {
    return this.#bytesReceived;
  }

  get fileBytes(): number {
    return this.#blob.size;
  }

  /** A Blob has no caches, and reading it needs no preparation. */
  warm(): void {}
  bypassCaches(): void {}
  forget(): void {}

  /** The first bytes of the file: `count`, or all of a smaller file. */
  firstBytes(count: number, signal: AbortSignal): Promise<Uint8Array> {
    return this.#read(0, Math.min(count, this.#blob.size), signal);
  }

  async header(signal: AbortSignal): Promise<Uint8Array> {
    const header = await this.firstBytes(maxHeaderBytes, signal);
    if (beginsAsStore(header)) return header;
    throw new StreamError("not-a-store", `${this.name}: expected a store, found something else`);
  }

  async contentId(signal: AbortSignal): Promise<string> {
    return contentIdOf(await this.header(signal));
  }

  async range(
    offset: number,
    bytes: number,
    signal: AbortSignal,
    arrived: (part: Uint8Array, offset: number) => void,
  ): Promise<void> {
    arrived(await this.#read(offset, bytes, signal), offset);
  }

  async pages(
    pages: readonly PagePlace[],
    signal: AbortSignal,
    arrived: (index: number, bytes: Uint8Array) => void,
  ): Promise<void> {
    for (const { index, offset, bytes } of pages) {
      arrived(index, await this.#read(offset, bytes, signal));
    }
  }

  async chunks<C extends ChunkPlaceInFile>(
    chunks: readonly C[],
    signal: AbortSignal,
    arrived: (chunk: C, bytes: Uint8Array) => void,
  ): Promise<void> {
    for (const range of ranges(chunks)) {
      const read = await this.#read(range.offset, range.bytes, signal);
      for (const chunk of range.chunks) {
        const at = chunk.offset - range.offset;
        arrived(chunk, read.slice(at, at + chunk.bytes));
      }
    }
  }

  group<C extends ChunkPlaceInFile>(chunks: readonly C[]): C[][] {
    // Reading is cheap, so groups are small, and newly needed chunks do not have to wait.
    const groups: C[][] = [];
    for (let at = 0; at < chunks.length; at += 4) groups.push(chunks.slice(at, at + 4));
    return groups;
  }

  async #read(offset: number, bytes: number, signal: AbortSignal): Promise<Uint8Array> {
    signal.throwIfAborted();
    if (offset + bytes > this.#blob.size) {
      throw new StreamError(
        "cut-short",
        `${this.name}: expected ${bytes} bytes from ${offset}, found a file of ${this.#blob.size}: ` +
          "the file was cut short",
      );
    }
    this.#requests += 1;
    let read: Uint8Array;
    try {
      read = new Uint8Array(await this.#blob.slice(offset, offset + bytes).arrayBuffer());
    } catch (error) {
      if (error instanceof StreamError) throw error;
      const message = `${this.name}: cannot be read any more: it was changed, moved or removed; open it again`;
      throw new StreamError("unreachable", message, error);
    }
    signal.throwIfAborted();
    this.#bytesReceived += read.byteLength;
    return read;
  }
}
