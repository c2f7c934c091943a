import type { FieldInfo } from "../core/types.ts";
import { KeptSource } from "./kept_source.ts";
import { RangeSource } from "./range_source.ts";
import type { Source } from "./source.ts";

/** Bytes of the first request for the header. The headers of most fields are much smaller than their limit. */
const firstHeaderBytes = 8 * 1024;
const maxHeaderBytes = 64 * 1024;

/** A field of a store: a part of the store's file, which has the form of a store itself. */
export class FieldSource extends RangeSource {
  readonly name: string;
  readonly #store: Source;
  readonly #field: FieldInfo;

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

  async header(signal: AbortSignal, whole = false): Promise<Uint8Array> {
    const limit = whole ? maxHeaderBytes : firstHeaderBytes;
    const header = new Uint8Array(Math.min(limit, this.#field.bytes));
    await this.range(0, header.length, signal, (part, offset) => header.set(part, offset));
    return header;
  }

  range(
    offset: number,
    bytes: number,
    signal: AbortSignal,
    arrived: (part: Uint8Array, offset: number) => void,
  ): Promise<void> {
    const begin = this.#field.offset;
    return this.#store.range(begin + offset, bytes, signal, (part, at) =>
      arrived(part, at - begin),
    );
  }

  bypassCaches(): void {
    this.#store.bypassCaches();
  }

  contentId(signal: AbortSignal): Promise<string> {
    return this.#store.contentId(signal);
  }

  /** Does nothing: the field belongs to a store that is open. */
  forget(): void {}
}
