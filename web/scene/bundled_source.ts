import { RangeSource } from "../stream/range_source.ts";
import type { FileRange } from "../stream/source.ts";
import { StreamError } from "../stream/types.ts";
import type { Bundle } from "./bundle.ts";
import { type BundledFile, piecesOf } from "./bundle_header.ts";

/**
 * The number of ranges that may be requested at a time, so that MergedRanges can merge those close to each other:
 * one for each layer, within these limits.
 */
const rangesWaiting = { least: 32, most: 256 };

/** A store in a bundle. */
export class BundledSource extends RangeSource {
  readonly name: string;
  readonly #bundle: Bundle;
  readonly #path: string;
  readonly #layers: number;
  /** The store according to the header that was read last. */
  #store: BundledFile | null = null;
  #requests = 0;
  #bytesReceived = 0;

  /** layers: the number of layers whose stores are in the bundle. */
  constructor(bundle: Bundle, path: string, layers = 1) {
    super();
    this.#bundle = bundle;
    this.#path = path;
    this.#layers = layers;
    this.name = `${bundle.file.name}: ${path}`;
  }

  /** The address of the bundle, with the store's path as its fragment. */
  get address(): string | undefined {
    const { address } = this.#bundle.file;
    return address && `${address}#${encodeURI(this.#path)}`;
  }

  get ready(): FileRange | undefined {
    const store = this.#store;
    return store ? { offset: store.bootstrapOffset, bytes: store.bootstrapBytes } : undefined;
  }

  get isLocal(): boolean {
    return this.#bundle.file.isLocal ?? false;
  }

  get concurrency(): number {
    const { least, most } = rangesWaiting;
    const ranges = Math.min(Math.max(least, this.#layers), most);
    return Math.max(ranges, this.#bundle.file.concurrency);
  }

  get fresh(): boolean {
    return this.#bundle.file.fresh;
  }

  /** The requests for this store alone. Requests that fetch parts of several stores are not counted. */
  get requests(): number {
    return this.#requests;
  }

  get bytesReceived(): number {
    return this.#bytesReceived;
  }

  get fileBytes(): number | undefined {
    return this.#store?.fileBytes;
  }

  /** Does nothing, because the bundle's header has already been read. */
  warm(): void {}

  async header(signal: AbortSignal): Promise<Uint8Array> {
    this.#store = await this.#bundle.store(this.#path, signal);
    const header = new Uint8Array(this.#store.headerBytes);
    await this.range(0, header.length, signal, (part, offset) => header.set(part, offset));
    return header;
  }

  async range(
    offset: number,
    bytes: number,
    signal: AbortSignal,
    arrived: (part: Uint8Array, offset: number) => void,
  ): Promise<void> {
    const store = this.#store ?? (await this.#bundle.store(this.#path, signal));
    if (offset + bytes > store.fileBytes) {
      throw new StreamError(
        "cut-short",
        `${this.name}: expected ${bytes} bytes from ${offset}, found a store of ${store.fileBytes}`,
      );
    }
    for (const piece of piecesOf(store, offset, bytes)) {
      const shift = piece.storeOffset - piece.bundleOffset;
      const isKept = await this.#bundle.range(
        piece.bundleOffset,
        piece.bytes,
        signal,
        (part, at) => {
          this.#bytesReceived += part.length;
          arrived(part, at + shift);
        },
      );
      if (!isKept) ++this.#requests;
    }
  }

  bypassCaches(): void {
    this.#bundle.bypassCaches();
  }

  async contentId(signal: AbortSignal): Promise<string> {
    const { stores } = await this.#bundle.reread(signal);
    const store = stores.get(this.#path);
    if (store) return store.contentId;
    throw new StreamError("not-found", `${this.name}: the bundle has no such store any more`);
  }

  /** Forgets the store's ranges. The next request uses the header that `contentId` has read, or reads it again. */
  forget(): void {
    this.#store = null;
  }
}
