import type { ChunkPlaceInFile, PagePlace, Source } from "./source.ts";
import { joined, Traffic, transfer, transferWhole } from "./transfer.ts";
import { StreamError } from "./types.ts";

/**
 * Bytes between two chunks that are fetched with them rather than by another request: what a link
 * of 20 Mbit/s carries in 13 ms, a third of a round trip.
 */
const gapWorthFetching = 32 * 1024;
/** One request carries at most so much: the order of need may change while it is under way. */
const mostBytesTogether = 1024 * 1024;
/** Neighbours are looked for among so many of the most needed chunks. */
const chunksLookedAt = 48;
/** Heads are mostly much smaller than their limit. */
const firstHeadBytes = 16 * 1024;

export interface Stretch<C> {
  offset: number;
  bytes: number;
  chunks: C[];
}

/** Joins places in a file that are neighbours, or nearly, to stretches of at most `most` bytes. */
export function stretches<C extends { offset: number; bytes: number }>(
  places: readonly C[],
  gap = gapWorthFetching,
  most = mostBytesTogether,
): Stretch<C>[] {
  const result: Stretch<C>[] = [];
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

/** A store as one file on any host that answers HTTP Range requests. */
export class FileSource implements Source {
  readonly name: string;
  protected readonly traffic = new Traffic();
  #fresh = false;
  #warm: Promise<Uint8Array> | undefined;

  constructor(url: string) {
    this.name = url;
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

  distrustCaches(): void {
    this.#fresh = true;
  }

  protected get fresh(): boolean {
    return this.#fresh;
  }

  protected fileUrl(): string {
    return this.name;
  }

  warm(): void {
    this.#warm ??= this.fetchHead(new AbortController().signal, false);
    // A failure is met again, and told, when the head is asked for.
    this.#warm.catch(() => {});
  }

  async head(signal: AbortSignal, whole = false): Promise<Uint8Array> {
    const warm = this.#warm;
    this.#warm = undefined;
    if (warm && !whole) {
      const head = await warm.catch(() => undefined);
      signal.throwIfAborted();
      if (head) return head;
    }
    return this.fetchHead(signal, whole);
  }

  protected async fetchHead(signal: AbortSignal, whole: boolean): Promise<Uint8Array> {
    const last = (whole ? 64 * 1024 : firstHeadBytes) - 1;
    const options = { range: [0, last] as const, fresh: this.fresh };
    return transferWhole(this.fileUrl(), options, this.traffic, signal);
  }

  async range(
    offset: number,
    bytes: number,
    signal: AbortSignal,
    arrived: (part: Uint8Array, offset: number) => void,
  ): Promise<void> {
    let at = offset;
    const options = { range: [offset, offset + bytes - 1] as const, fresh: this.fresh };
    await transfer(this.fileUrl(), options, this.traffic, signal, (part) => {
      arrived(part, at);
      at += part.length;
    });
    if (at !== offset + bytes) {
      throw new StreamError(
        "unreachable",
        `${this.name}: expected ${bytes} bytes from ${offset}, found ${at - offset}: the file may ` +
          "have been cut short or replaced",
        true,
      );
    }
  }

  async pages(
    pages: readonly PagePlace[],
    signal: AbortSignal,
    arrived: (index: number, bytes: Uint8Array) => void,
  ): Promise<void> {
    await this.#fetchStretches(pages, signal, (page, bytes) => arrived(page.index, bytes));
  }

  async chunks<C extends ChunkPlaceInFile>(
    chunks: readonly C[],
    signal: AbortSignal,
    arrived: (chunk: C, bytes: Uint8Array) => void,
  ): Promise<void> {
    await this.#fetchStretches(chunks, signal, arrived);
  }

  group<C extends ChunkPlaceInFile>(chunks: readonly C[]): C[][] {
    // Sets keep the order of need: a stretch is as urgent as its most needed chunk.
    const rank = new Map(chunks.map((chunk, i) => [chunk, i]));
    const mostNeeded = (stretch: Stretch<C>): number =>
      Math.min(...stretch.chunks.map((chunk) => rank.get(chunk) ?? 0));
    return stretches(chunks.slice(0, chunksLookedAt))
      .sort((a, b) => mostNeeded(a) - mostNeeded(b))
      .map((stretch) => stretch.chunks);
  }

  async #fetchStretches<C extends { offset: number; bytes: number }>(
    places: readonly C[],
    signal: AbortSignal,
    arrived: (place: C, bytes: Uint8Array) => void,
  ): Promise<void> {
    await Promise.all(
      stretches(places).map((stretch) => {
        const cutter = new Cutter(stretch, arrived);
        return this.range(stretch.offset, stretch.bytes, signal, (part, offset) =>
          cutter.add(part, offset),
        );
      }),
    );
  }
}

/** Cuts a stretch into its places while it arrives. */
class Cutter<C extends { offset: number; bytes: number }> {
  readonly #places: C[];
  readonly #arrived: (place: C, bytes: Uint8Array) => void;
  #parts: Uint8Array[] = [];
  #have = 0;

  constructor(stretch: Stretch<C>, arrived: (place: C, bytes: Uint8Array) => void) {
    this.#places = [...stretch.chunks];
    this.#arrived = arrived;
  }

  add(part: Uint8Array, offset: number): void {
    for (;;) {
      const place = this.#places[0];
      if (!place) return;
      const from = Math.max(place.offset + this.#have - offset, 0);
      const to = Math.min(place.offset + place.bytes - offset, part.length);
      if (to > from) {
        // A copy: the part is the transport's, and may hold other places too.
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
