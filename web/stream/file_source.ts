import { maxHeaderBytes } from "../core/core.ts";
import type { ChunkPlaceInFile, PagePlace, Source } from "./source.ts";
import {
  type Admittance,
  beginsAsStore,
  type FileIdentity,
  joined,
  Traffic,
  transfer,
} from "./transfer.ts";
import { StreamError } from "./types.ts";
import { fetchWhole } from "./whole_file.ts";

/**
 * Two chunks with at most this many bytes between them are fetched by one request. A link of 20 Mbit/s
 * carries these bytes in 13 ms, a third of a round trip.
 */
const gapWorthFetching = 32 * 1024;
/**
 * The largest request (bytes). It is limited because priorities may change while a request is in
 * flight.
 */
const maxBytesTogether = 1024 * 1024;
/** Requests are merged among this number of chunks of highest priority. */
const chunksLookedAt = 48;
/** The first request for the header. Most headers are much smaller than their limit. */
const firstHeaderBytes = 16 * 1024;
/** The offset of the content id in the header (shared/core/store/FORMAT.md). */
const contentIdPlace = [32, 48] as const;

export interface ByteRange<C> {
  offset: number;
  bytes: number;
  chunks: C[];
}

/** Merges adjacent or nearly adjacent parts of a file into ranges of at most `most` bytes. */
export function ranges<C extends { offset: number; bytes: number }>(
  places: readonly C[],
  gap = gapWorthFetching,
  most = maxBytesTogether,
): ByteRange<C>[] {
  const result: ByteRange<C>[] = [];
  for (const place of [...places].sort((a, b) => a.offset - b.offset)) {
    const last = result.at(-1);
    const end = place.offset + place.bytes;
    if (
      last &&
      place.offset - (last.offset + last.bytes) <= gap &&
      end - last.offset <= most &&
      place.offset >= last.offset
    ) {
      last.bytes = Math.max(last.bytes, end - last.offset);
      last.chunks.push(place);
    } else {
      result.push({ offset: place.offset, bytes: place.bytes, chunks: [place] });
    }
  }
  return result;
}

export interface SourceOptions extends Admittance {
  /** A connection counts as broken after this time without data (ms). Default: 20 s. */
  longestSilence?: number;
}

/**
 * A store as one file on any host that answers HTTP Range requests. From other hosts, small stores are
 * fetched as a whole, with a warning.
 */
export class FileSource implements Source {
  readonly name: string;
  protected readonly traffic = new Traffic();
  #fresh = false;
  #warm: { header: Promise<Uint8Array>; whole: boolean } | undefined;
  /**
   * The statements of earlier responses about the file, and whether a different ETag means a different
   * file.
   */
  #etag: string | undefined;
  #fileBytes: number | undefined;
  #etagIdentifies = true;
  /** The file, if its host does not serve parts of it. */
  #whole: Promise<Uint8Array> | undefined;
  #hasWarned = false;

  constructor(url: string, options: SourceOptions = {}) {
    this.name = url;
    const { headers, credentials, query } = options;
    this.traffic.admittance = {
      ...(headers && { headers: { ...headers } }),
      ...(credentials && { credentials }),
      ...(query && { query }),
    };
    if (options.longestSilence) this.traffic.longestSilence = options.longestSilence;
  }

  get concurrency(): number {
    return 6;
  }

  get requests(): number {
    return this.traffic.requests;
  }

  get bytesReceived(): number {
    return this.traffic.bytesReceived;
  }

  get fileBytes(): number | undefined {
    return this.#fileBytes;
  }

  bypassCaches(): void {
    this.#fresh = true;
  }

  forget(): void {
    this.#warm = undefined;
    this.#etag = undefined;
    this.#fileBytes = undefined;
    this.#fresh = false;
    this.#whole = undefined;
  }

  async contentId(signal: AbortSignal): Promise<string> {
    const before = { etag: this.#etag, bytes: this.#fileBytes };
    this.#etag = undefined;
    this.#fileBytes = undefined;
    const [, end] = contentIdPlace;
    try {
      const header: Uint8Array[] = [];
      await this.#ask([0, end - 1], signal, (part) => header.push(part), true);
      const bytes = joined(header);
      if (!beginsAsStore(bytes)) {
        throw new StreamError(
          "not-a-store",
          `${this.name}: expected a store, found something else`,
        );
      }
      // Hosts that consist of several machines may send different ETags for the same file.
      const isOtherEtag = before.etag !== undefined && this.#etag !== before.etag;
      if (isOtherEtag && before.bytes === this.#fileBytes) this.#etagIdentifies = false;
      return contentIdOf(bytes);
    } catch (error) {
      this.#etag = before.etag;
      this.#fileBytes = before.bytes;
      throw error;
    }
  }

  /** Checks that a response belongs to the file that was opened. */
  readonly #identify = ({ etag, bytes }: FileIdentity): void => {
    const isOther =
      (bytes !== undefined && this.#fileBytes !== undefined && bytes !== this.#fileBytes) ||
      (this.#etagIdentifies &&
        etag !== undefined &&
        this.#etag !== undefined &&
        etag !== this.#etag);
    if (isOther) {
      throw new StreamError(
        "replaced",
        `${this.name}: expected the file that was opened (${this.#fileBytes} bytes, ETag ` +
          `${this.#etag}), found another (${bytes} bytes, ETag ${etag})`,
      );
    }
    this.#etag ??= etag;
    this.#fileBytes ??= bytes;
  };

  get fresh(): boolean {
    return this.#fresh;
  }

  protected fileUrl(): string {
    return this.name;
  }

  warm(): void {
    if (this.#warm) return;
    const header = this.fetchHeader(new AbortController().signal, this.fresh);
    // header() reports a failure.
    header.catch(() => {});
    this.#warm = { header, whole: this.fresh };
  }

  async header(signal: AbortSignal, whole = false): Promise<Uint8Array> {
    const warm = this.#warm;
    this.#warm = undefined;
    if (warm && (warm.whole || !whole)) {
      try {
        return await warm.header;
      } finally {
        signal.throwIfAborted();
      }
    }
    return this.fetchHeader(signal, whole);
  }

  protected async fetchHeader(signal: AbortSignal, whole: boolean): Promise<Uint8Array> {
    const parts: Uint8Array[] = [];
    const last = (whole ? maxHeaderBytes : firstHeaderBytes) - 1;
    await this.#ask([0, last], signal, (part) => parts.push(part));
    return joined(parts);
  }

  async range(
    offset: number,
    bytes: number,
    signal: AbortSignal,
    arrived: (part: Uint8Array, offset: number) => void,
  ): Promise<void> {
    let at = offset;
    await this.#ask([offset, offset + bytes - 1], signal, (part) => {
      arrived(part, at);
      at += part.length;
    });
    // The response is complete according to its headers, so the file ends here.
    if (at !== offset + bytes) {
      throw new StreamError(
        "cut-short",
        `${this.name}: expected ${bytes} bytes from ${offset}, found ${at - offset}` +
          `${this.#fileBytes === undefined ? "" : ` of a file of ${this.#fileBytes}`}: the file ` +
          "was cut short",
      );
    }
  }

  async #ask(
    range: readonly [first: number, last: number],
    signal: AbortSignal,
    arrived: (part: Uint8Array) => void,
    fresh = this.fresh,
  ): Promise<void> {
    if (this.#whole && !fresh) return this.#askWhole(range, signal, arrived);
    const options = { range, fresh, identify: this.#identify };
    try {
      await transfer(this.fileUrl(), options, this.traffic, signal, arrived);
    } catch (error) {
      if (!(error instanceof StreamError) || error.kind !== "no-range") throw error;
      if (fresh) this.#whole = undefined;
      await this.#askWhole(range, signal, arrived, fresh);
    }
  }

  async #askWhole(
    [first, last]: readonly [first: number, last: number],
    signal: AbortSignal,
    arrived: (part: Uint8Array) => void,
    fresh = false,
  ): Promise<void> {
    if (!this.#whole) {
      const options = { fresh, identify: this.#identify };
      const whole = fetchWhole(this.fileUrl(), options, this.traffic);
      this.#whole = whole;
      whole.then(
        () => this.#warnOfWhole(),
        () => {
          if (this.#whole === whole) this.#whole = undefined;
        },
      );
    }
    const bytes = await this.#whole;
    signal.throwIfAborted();
    if (first < bytes.length) arrived(bytes.subarray(first, last + 1));
  }

  #warnOfWhole(): void {
    if (this.#hasWarned) return;
    this.#hasWarned = true;
    console.warn(
      `${this.name}: this host does not serve parts of files (HTTP Range): the store was fetched whole`,
    );
  }

  async pages(
    pages: readonly PagePlace[],
    signal: AbortSignal,
    arrived: (index: number, bytes: Uint8Array) => void,
  ): Promise<void> {
    await this.#fetchRanges(pages, signal, (page, bytes) => arrived(page.index, bytes));
  }

  async chunks<C extends ChunkPlaceInFile>(
    chunks: readonly C[],
    signal: AbortSignal,
    arrived: (chunk: C, bytes: Uint8Array) => void,
  ): Promise<void> {
    await this.#fetchRanges(chunks, signal, arrived);
  }

  group<C extends ChunkPlaceInFile>(chunks: readonly C[]): C[][] {
    // Sets keep the order of insertion, so a range gets the priority of its most important chunk.
    const rank = new Map(chunks.map((chunk, i) => [chunk, i]));
    const mostNeeded = (range: ByteRange<C>): number =>
      Math.min(...range.chunks.map((chunk) => rank.get(chunk) ?? 0));
    return ranges(chunks.slice(0, chunksLookedAt))
      .sort((a, b) => mostNeeded(a) - mostNeeded(b))
      .map((range) => range.chunks);
  }

  async #fetchRanges<C extends { offset: number; bytes: number }>(
    places: readonly C[],
    signal: AbortSignal,
    arrived: (place: C, bytes: Uint8Array) => void,
  ): Promise<void> {
    await together(signal, this.concurrency, ranges(places), (range, ending) => {
      const cutter = new Cutter(range, arrived);
      return this.range(range.offset, range.bytes, ending, (part, offset) =>
        cutter.add(part, offset),
      );
    });
  }
}

/**
 * Runs a function for all items, for at most `concurrency` of them at a time, in their order. If it fails
 * for one item, the others are aborted. Settles when all have ended; rejects with the first failure.
 */
export async function together<T>(
  signal: AbortSignal,
  concurrency: number,
  items: readonly T[],
  work: (item: T, signal: AbortSignal) => Promise<void>,
): Promise<void> {
  const ending = new AbortController();
  const aborted = (): void => ending.abort(signal.reason);
  signal.addEventListener("abort", aborted, { once: true });
  if (signal.aborted) aborted();
  const failures: unknown[] = [];
  let next = 0;
  const runOneByOne = async (): Promise<void> => {
    for (let at = next++; at < items.length && !ending.signal.aborted; at = next++) {
      try {
        await work(items[at] as T, ending.signal);
      } catch (error) {
        failures.push(error);
        ending.abort(new DOMException("another request of the group has failed", "AbortError"));
      }
    }
  };
  await Promise.all(Array.from({ length: Math.min(concurrency, items.length) }, runOneByOne));
  signal.removeEventListener("abort", aborted);
  signal.throwIfAborted();
  if (failures.length > 0) throw failures[0];
}

/** The content id in the first bytes of a store. */
export function contentIdOf(header: Uint8Array): string {
  return hexadecimal(header.subarray(...contentIdPlace));
}

export function hexadecimal(bytes: Uint8Array): string {
  return Array.from(bytes, (byte) => byte.toString(16).padStart(2, "0")).join("");
}

/** Splits a range into its parts while it arrives. */
class Cutter<C extends { offset: number; bytes: number }> {
  readonly #places: C[];
  readonly #arrived: (place: C, bytes: Uint8Array) => void;
  #parts: Uint8Array[] = [];
  #have = 0;

  constructor(range: ByteRange<C>, arrived: (place: C, bytes: Uint8Array) => void) {
    this.#places = [...range.chunks];
    this.#arrived = arrived;
  }

  add(part: Uint8Array, offset: number): void {
    for (;;) {
      const place = this.#places[0];
      if (!place) return;
      const from = Math.max(place.offset + this.#have - offset, 0);
      const to = Math.min(place.offset + place.bytes - offset, part.length);
      if (to > from) {
        // A copy, because the transport's buffer may contain other parts too.
        this.#parts.push(part.slice(from, to));
        this.#have += to - from;
      }
      if (this.#have < place.bytes) return;
      this.#places.shift();
      const bytes = joined(this.#parts);
      this.#parts = [];
      this.#have = 0;
      this.#arrived(place, bytes);
    }
  }
}
