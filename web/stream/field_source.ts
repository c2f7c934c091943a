import type { FieldInfo } from "../core/types.ts";
import { KeptSource } from "./kept_source.ts";
import { RangeSource } from "./range_source.ts";
import type { Source } from "./source.ts";
import { joined } from "./transfer.ts";

/** Bytes of the first request for the header. The headers of most fields are much smaller than their limit. */
const firstHeaderBytes = 8 * 1024;
const maxHeaderBytes = 64 * 1024;
/** The most bytes of pages and coarse chunks that are requested with the header, because the first picture needs them. */
const mostTailBytes = 64 * 1024;
/** The most bytes that are requested when a field is opened. */
export const fieldOpeningBytes = firstHeaderBytes + mostTailBytes;

/** A part of the end of a field, which is requested with the header. */
interface Tail {
  offset: number;
  end: number;
  /** Undefined if it could not be fetched. */
  bytes: Promise<Uint8Array | undefined>;
  request: AbortController;
}

/** A field of a store: a part of the store's file, which has the form of a store itself. */
export class FieldSource extends RangeSource {
  readonly name: string;
  readonly #store: Source;
  readonly #field: FieldInfo;
  readonly #pageBytes: number;
  #tail: Tail | undefined;
  #isAsked = false;

  /** `pageBytes`: the bytes of all pages of the store; those of the field have as many. */
  constructor(store: Source, field: FieldInfo, pageBytes: number) {
    super();
    this.name = `${store.name}, field ${field.name}`;
    // The ranges of a field would displace the coarse tail of a large store.
    this.#store = store instanceof KeptSource ? store.forFields : store;
    this.#field = field;
    this.#pageBytes = pageBytes;
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

  /** The first request for the header requests the coarsest pages at the same time, since they are needed next. */
  async header(signal: AbortSignal, whole = false): Promise<Uint8Array> {
    const limit = whole ? maxHeaderBytes : firstHeaderBytes;
    const header = this.#read(0, Math.min(limit, this.#field.bytes), signal);
    if (!this.#isAsked && !this.isLocal) this.#requestTail(signal);
    this.#isAsked = true;
    try {
      return await header;
    } catch (error) {
      this.#forgetTail();
      throw error;
    }
  }

  async range(
    offset: number,
    bytes: number,
    signal: AbortSignal,
    arrived: (part: Uint8Array, offset: number) => void,
  ): Promise<void> {
    const tail = this.#tail;
    if (tail && offset >= tail.offset && offset + bytes <= tail.end) {
      const read = await unlessAborted(tail.bytes, signal);
      if (read) {
        arrived(read.subarray(offset - tail.offset, offset - tail.offset + bytes), offset);
        return;
      }
    }
    const begin = this.#field.offset;
    await this.#store.range(begin + offset, bytes, signal, (part, at) => arrived(part, at - begin));
  }

  bypassCaches(): void {
    this.#forgetTail();
    this.#store.bypassCaches();
  }

  contentId(signal: AbortSignal): Promise<string> {
    return this.#store.contentId(signal);
  }

  /** Does nothing: the field belongs to a store that is open. */
  forget(): void {}

  /** Pages are at the end of the field, the coarsest first; before them are the coarsest chunks. */
  #requestTail(signal: AbortSignal): void {
    const end = this.#field.bytes;
    const offset = Math.max(0, end - Math.max(this.#pageBytes, mostTailBytes));
    const bytes = Math.min(end - offset, mostTailBytes);
    const request = new AbortController();
    const either = AbortSignal.any([signal, request.signal]);
    const read = this.#read(offset, bytes, either).catch(() => undefined);
    this.#tail = { offset, end: offset + bytes, bytes: read, request };
  }

  #forgetTail(): void {
    this.#tail?.request.abort(new DOMException("the tail is not needed", "AbortError"));
    this.#tail = undefined;
  }

  async #read(offset: number, bytes: number, signal: AbortSignal): Promise<Uint8Array> {
    const parts: Uint8Array[] = [];
    await this.#store.range(this.#field.offset + offset, bytes, signal, (part) => {
      parts.push(part.slice());
    });
    return joined(parts);
  }
}

/** Waits for a promise that never rejects; rejects as soon as the signal aborts. */
async function unlessAborted<T>(promise: Promise<T>, signal: AbortSignal): Promise<T> {
  signal.throwIfAborted();
  const ending = new AbortController();
  const aborted = new Promise<never>((_, reject) => {
    signal.addEventListener("abort", () => reject(signal.reason), { signal: ending.signal });
  });
  try {
    return await Promise.race([promise, aborted]);
  } finally {
    ending.abort();
  }
}
