import { type ByteRange, ranges } from "../stream/range_source.ts";
import type { FileRange, Source } from "../stream/source.ts";

/** Two ranges with at most this many bytes between them are fetched together, with these bytes. */
const maxGap = 16 * 1024;

type Arrived = (part: Uint8Array, offset: number) => void;

interface Wanted extends FileRange {
  signal: AbortSignal;
  arrived: Arrived;
  resolve: () => void;
  reject: (reason: unknown) => void;
}

/**
 * Fetches ranges of a file for many readers, such as the small stores of a bundle. At most
 * `concurrency` requests run at a time. The other ranges wait; those that lie close to each other are
 * then fetched by one request.
 */
export class MergedRanges {
  readonly #file: Pick<Source, "range" | "concurrency">;
  /** In the order of their calls, the oldest first. */
  #waiting: Wanted[] = [];
  #running = 0;
  #begins = false;

  constructor(file: Pick<Source, "range" | "concurrency">) {
    this.#file = file;
  }

  /** As Source.range. Rejects with the error of the request, or with the signal's reason. */
  range(offset: number, bytes: number, signal: AbortSignal, arrived: Arrived): Promise<void> {
    if (signal.aborted) return Promise.reject(signal.reason);
    let aborted = (): void => {};
    return new Promise<void>((resolve, reject) => {
      const wanted: Wanted = { offset, bytes, signal, arrived, resolve, reject };
      aborted = () => {
        this.#waiting = this.#waiting.filter((each) => each !== wanted);
        reject(signal.reason);
      };
      signal.addEventListener("abort", aborted);
      this.#waiting.push(wanted);
      this.#begin();
    }).finally(() => signal.removeEventListener("abort", aborted));
  }

  /** Starts requests in a microtask, so that ranges requested in the same task can be merged. */
  #begin(): void {
    if (this.#begins) return;
    this.#begins = true;
    queueMicrotask(() => {
      this.#begins = false;
      while (this.#running < this.#file.concurrency) {
        const next = this.#next();
        if (!next) return;
        void this.#fetch(next);
      }
    });
  }

  /** Removes the range that has waited longest, and those that are fetched with it. */
  #next(): ByteRange<Wanted> | undefined {
    const [oldest] = this.#waiting;
    if (!oldest) return undefined;
    const next = ranges(this.#waiting, maxGap).find(({ chunks }) => chunks.includes(oldest));
    const taken = new Set(next?.chunks);
    this.#waiting = this.#waiting.filter((each) => !taken.has(each));
    return next;
  }

  async #fetch({ offset, bytes, chunks: group }: ByteRange<Wanted>): Promise<void> {
    ++this.#running;
    const ending = new AbortController();
    const endIfUnwanted = (): void => {
      if (group.every(({ signal }) => signal.aborted)) ending.abort(group[0]?.signal.reason);
    };
    for (const { signal } of group) signal.addEventListener("abort", endIfUnwanted);
    try {
      await this.#file.range(offset, bytes, ending.signal, (part, at) => handOut(group, part, at));
      for (const { resolve } of group) resolve();
    } catch (error) {
      for (const { reject } of group) reject(error);
    } finally {
      --this.#running;
      for (const { signal } of group) signal.removeEventListener("abort", endIfUnwanted);
      this.#begin();
    }
  }
}

/** Passes to each reader the bytes of a part that lie in its range. */
function handOut(group: readonly Wanted[], part: Uint8Array, offset: number): void {
  for (const { offset: begin, bytes, signal, arrived } of group) {
    const from = Math.max(begin, offset);
    const to = Math.min(begin + bytes, offset + part.length);
    if (from < to && !signal.aborted) arrived(part.subarray(from - offset, to - offset), from);
  }
}
