import type { Source } from "../stream/source.ts";

/** Two ranges with at most this many bytes between them are fetched together, with these bytes. */
const maxGap = 16 * 1024;
/** Ranges are merged into one request of at most this size. A single range may be larger. */
const maxBytes = 1024 * 1024;

type Arrived = (part: Uint8Array, offset: number) => void;

interface Wanted {
  offset: number;
  end: number;
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
    return new Promise((resolve, reject) => {
      if (signal.aborted) {
        reject(signal.reason);
        return;
      }
      const wanted: Wanted = { offset, end: offset + bytes, signal, arrived, resolve, reject };
      this.#waiting.push(wanted);
      signal.addEventListener(
        "abort",
        () => {
          this.#waiting = this.#waiting.filter((each) => each !== wanted);
          reject(signal.reason);
        },
        { once: true },
      );
      this.#begin();
    });
  }

  /** Starts requests in a microtask, so that ranges requested in the same task can be merged. */
  #begin(): void {
    if (this.#begins) return;
    this.#begins = true;
    queueMicrotask(() => {
      this.#begins = false;
      while (this.#waiting.length > 0 && this.#running < this.#file.concurrency) {
        void this.#fetch(this.#next());
      }
    });
  }

  /** Removes the range that has waited longest, and those close to it. Returns them by offset. */
  #next(): Wanted[] {
    const [oldest] = this.#waiting;
    if (!oldest) return [];
    const sorted = [...this.#waiting].sort((a, b) => a.offset - b.offset);
    const at = sorted.indexOf(oldest);
    let { offset: begin, end } = oldest;
    const group = [oldest];
    for (const next of sorted.slice(at + 1)) {
      if (next.offset - end > maxGap || next.end - begin > maxBytes) break;
      end = Math.max(end, next.end);
      group.push(next);
    }
    for (const before of sorted.slice(0, at).reverse()) {
      if (begin - before.end > maxGap || end - before.offset > maxBytes) break;
      begin = Math.min(begin, before.offset);
      group.unshift(before);
    }
    const taken = new Set(group);
    this.#waiting = this.#waiting.filter((each) => !taken.has(each));
    return group;
  }

  async #fetch(group: readonly Wanted[]): Promise<void> {
    const [first] = group;
    if (!first) return;
    ++this.#running;
    const ending = new AbortController();
    const endIfUnwanted = (): void => {
      if (group.every(({ signal }) => signal.aborted)) ending.abort(first.signal.reason);
    };
    for (const { signal } of group) signal.addEventListener("abort", endIfUnwanted, { once: true });
    const end = Math.max(...group.map((each) => each.end));
    try {
      await this.#file.range(first.offset, end - first.offset, ending.signal, (part, offset) =>
        handOut(group, part, offset),
      );
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
  for (const { offset: begin, end, signal, arrived } of group) {
    const from = Math.max(begin, offset);
    const to = Math.min(end, offset + part.length);
    if (from < to && !signal.aborted) arrived(part.subarray(from - offset, to - offset), from);
  }
}
