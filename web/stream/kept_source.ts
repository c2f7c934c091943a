import type { KeptBytes } from "./kept_bytes.ts";
import type { ChunkPlaceInFile, FileRange, PagePlace, Source } from "./source.ts";
import { joined } from "./transfer.ts";

/** A source that keeps its bytes after their arrival. Reading kept bytes makes no request. */
export class KeptSource implements Source {
  readonly #source: Source;
  readonly #kept: KeptBytes;
  readonly #keepsParts: boolean;
  #header: Uint8Array | undefined;

  /** `keepsParts`: whether pages and chunks are kept, and not only the header and byte ranges (the coarse tail). */
  constructor(source: Source, kept: KeptBytes, { keepsParts = true } = {}) {
    this.#source = source;
    this.#kept = kept;
    this.#keepsParts = keepsParts;
  }

  get name(): string {
    return this.#source.name;
  }

  get address(): string | undefined {
    return this.#source.address;
  }

  get ready(): FileRange | undefined {
    return this.#source.ready;
  }

  get isLocal(): boolean {
    return this.#source.isLocal ?? false;
  }

  get spacingOf(): Source["spacingOf"] {
    return this.#source.spacingOf;
  }

  get concurrency(): number {
    return this.#source.concurrency;
  }

  get requests(): number {
    return this.#source.requests;
  }

  get bytesReceived(): number {
    return this.#source.bytesReceived;
  }

  get fileBytes(): number | undefined {
    return this.#source.fileBytes;
  }

  get fresh(): boolean {
    return this.#source.fresh;
  }

  /** The source for parts of the file that are not to be kept, unless all are. */
  get forFields(): Source {
    return this.#keepsParts ? this : this.#source;
  }

  warm(): void {
    if (!this.#header) this.#source.warm();
  }

  async header(signal: AbortSignal, whole?: boolean): Promise<Uint8Array> {
    // Headers are always kept, because they are small and always needed.
    if (this.#header && !whole) return this.#header.slice();
    const header = await this.#source.header(signal, whole);
    this.#header = header.slice();
    return header;
  }

  async range(
    offset: number,
    bytes: number,
    signal: AbortSignal,
    arrived: (part: Uint8Array, offset: number) => void,
  ): Promise<void> {
    const kept = this.#kept.take(this, offset, bytes);
    if (kept) {
      arrived(kept, offset);
      return;
    }
    const parts: Uint8Array[] = [];
    await this.#source.range(offset, bytes, signal, (part, at) => {
      parts.push(part.slice());
      arrived(part, at);
    });
    this.#kept.keep(this, offset, joined(parts));
  }

  async pages(
    pages: readonly PagePlace[],
    signal: AbortSignal,
    arrived: (index: number, bytes: Uint8Array) => void,
  ): Promise<void> {
    const missing = this.#missing(pages, ({ index }, bytes) => arrived(index, bytes));
    if (missing.length === 0) return;
    await this.#source.pages(missing, signal, (index, bytes) => {
      const page = missing.find((each) => each.index === index);
      if (page && this.#keepsParts) this.#kept.keep(this, page.offset, bytes);
      arrived(index, bytes);
    });
  }

  async chunks<C extends ChunkPlaceInFile>(
    chunks: readonly C[],
    signal: AbortSignal,
    arrived: (chunk: C, bytes: Uint8Array) => void,
  ): Promise<void> {
    const missing = this.#missing(chunks, arrived);
    if (missing.length === 0) return;
    await this.#source.chunks(missing, signal, (chunk, bytes) => {
      if (this.#keepsParts) this.#kept.keep(this, chunk.offset, bytes);
      arrived(chunk, bytes);
    });
  }

  /** Passes on the kept parts, and returns the others. */
  #missing<P extends { offset: number; bytes: number }>(
    places: readonly P[],
    arrived: (place: P, bytes: Uint8Array) => void,
  ): P[] {
    return places.filter((place) => {
      const bytes = this.#kept.take(this, place.offset, place.bytes);
      if (bytes) arrived(place, bytes);
      return !bytes;
    });
  }

  bypassCaches(): void {
    this.#forget();
    this.#source.bypassCaches();
  }

  contentId(signal: AbortSignal): Promise<string> {
    return this.#source.contentId(signal);
  }

  forget(): void {
    this.#forget();
    this.#source.forget();
  }

  #forget(): void {
    this.#header = undefined;
    this.#kept.forget(this);
  }

  /** Chunks that are kept form a group of their own, which makes no request. */
  group<C extends ChunkPlaceInFile>(chunks: readonly C[]): C[][] {
    const kept: C[] = [];
    const missing: C[] = [];
    for (const chunk of chunks) (this.has(chunk) ? kept : missing).push(chunk);
    const groups = this.#source.group(missing);
    return kept.length > 0 ? [kept, ...groups] : groups;
  }

  /** Whether reading this range makes no request. */
  has({ offset, bytes }: FileRange): boolean {
    return this.#kept.has(this, offset, bytes);
  }
}
