import type { ChunkPlaceInFile, PagePlace, Source } from "./source.ts";
import { joined } from "./transfer.ts";

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
/** Only this number of chunks, those of highest priority, are merged into requests. */
const chunksConsidered = 48;

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

/**
 * A source that fetches byte ranges of the store file. Ranges close to each other share a request.
 */
export abstract class RangeSource implements Source {
  abstract readonly name: string;
  abstract readonly concurrency: number;
  abstract readonly requests: number;
  abstract readonly bytesReceived: number;
  abstract readonly fresh: boolean;
  abstract readonly fileBytes: number | undefined;

  abstract warm(): void;
  abstract header(signal: AbortSignal, whole?: boolean): Promise<Uint8Array>;
  abstract range(
    offset: number,
    bytes: number,
    signal: AbortSignal,
    arrived: (part: Uint8Array, offset: number) => void,
  ): Promise<void>;
  abstract bypassCaches(): void;
  abstract contentId(signal: AbortSignal): Promise<string>;
  abstract forget(): void;

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
    // A range has the priority of its most needed chunk.
    const rank = new Map(chunks.map((chunk, i) => [chunk, i]));
    const mostNeeded = (range: ByteRange<C>): number =>
      Math.min(...range.chunks.map((chunk) => rank.get(chunk) ?? 0));
    return ranges(chunks.slice(0, chunksConsidered))
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
        // Make a copy, because the transport's buffer may contain other parts too.
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
