import type { FieldInfo } from "../core/types.ts";
import { KeptSource } from "./kept_source.ts";
import { RangeSource } from "./range_source.ts";
import type { Source } from "./source.ts";
import { joined } from "./transfer.ts";

/** Bytes of the first request for the header. The headers of most fields are much smaller than their limit. */
const firstHeaderBytes = 8 * 1024;
const maxHeaderBytes = 64 * 1024;
/** Bytes at the end that are requested with the header: the pages, which the first picture needs, and coarse chunks. */
const tailBytes = 64 * 1024;

/** A field of a store: a part of the store's file, which has the form of a store itself. */
export class FieldSource extends RangeSource {
  readonly name: string;
  readonly #store: Source;
  readonly #field: FieldInfo;
  /** The end of the field, from the first request for the header on; undefined if it could not be fetched. */
  #tail: { offset: number; bytes: Promise<Uint8Array | undefined> } | undefined;

  constructor(store: Source, field: FieldInfo) {
    super();
    this.name = `${store.name}, field ${field.name}`;
    // The ranges of a field would displace the coarse tail of a large store.
    this.#store = store instanceof KeptSource ? store.forFields : store;
    this.#field = field;
  }

  get isLocal(): boolean {
    return this.#store.isLocal ?? false;
  }

  get concurrency(): number {
    return this.#store.concurrency;
  }

  get requests(): number {
    return this.#store.requests;
  }

  get bytesReceived(): number {
    return this.#store.bytesReceived;
  }

  get fresh(): boolean {
    return this.#store.fresh;
  }

  get fileBytes(): number {
    return this.#field.bytes;
  }

  /** Does nothing, because the store's header has to be read first. */
  warm(): void {}

  /** Requests the end of the field at the same time, since its pages are needed next. */
  async header(signal: AbortSignal, whole = false): Promise<Uint8Array> {
    const limit = whole ? maxHeaderBytes : firstHeaderBytes;
    const bytes = Math.min(limit, this.#field.bytes);
    if (!whole && !this.isLocal) {
      const offset = Math.max(this.#field.bytes - tailBytes, 0);
      this.#tail = {
        offset,
        bytes: this.#read(offset, this.#field.bytes - offset, signal).catch(() => undefined),
      };
    }
    return await this.#read(0, bytes, signal);
  }

  async range(
    offset: number,
    bytes: number,
    signal: AbortSignal,
    arrived: (part: Uint8Array, offset: number) => void,
  ): Promise<void> {
    const tail = this.#tail;
    if (tail && offset >= tail.offset) {
      const read = await tail.bytes;
      signal.throwIfAborted();
      if (read) {
        arrived(read.subarray(offset - tail.offset, offset - tail.offset + bytes), offset);
        return;
      }
    }
    const begin = this.#field.offset;
    await this.#store.range(begin + offset, bytes, signal, (part, at) => arrived(part, at - begin));
  }

  bypassCaches(): void {
    this.#tail = undefined;
    this.#store.bypassCaches();
  }

  contentId(signal: AbortSignal): Promise<string> {
    return this.#store.contentId(signal);
  }

  /** Does nothing: the field belongs to a store that is open. */
  forget(): void {}

  async #read(offset: number, bytes: number, signal: AbortSignal): Promise<Uint8Array> {
    const parts: Uint8Array[] = [];
    await this.#store.range(this.#field.offset + offset, bytes, signal, (part) => {
      parts.push(part.slice());
    });
    return joined(parts);
  }
}
