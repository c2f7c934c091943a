import { slowWait } from "./faults.ts";
import type { StreamError } from "./types.ts";

/**
 * Damaged parts, which fail although the source works. One of them is retried after 12 s, the next
 * one after another 14 s, then one every 16 s (`slowWait`). The part with the oldest attempt comes
 * first. Call `retryAll` when a part succeeds, because the file may have been repaired.
 */
export class FailedParts<T> {
  /** In order of their last failure, the oldest first. */
  readonly #failed = new Map<T, StreamError>();
  readonly #isNeeded: (item: T) => boolean;
  readonly #retry: (item: T) => void;
  #timer: ReturnType<typeof setTimeout> | undefined;
  /** Retries since the last `retryAll`. */
  #retries = 0;

  /** `retry` requests an item, which then no longer counts as failed. */
  constructor(isNeeded: (item: T) => boolean, retry: (item: T) => void) {
    this.#isNeeded = isNeeded;
    this.#retry = retry;
  }

  has(item: T): boolean {
    return this.#failed.has(item);
  }

  /** The number of failed parts that are needed, and the error of the first. */
  get needed(): { count: number; error: StreamError | undefined } {
    const needed = [...this.#failed].filter(([item]) => this.#isNeeded(item));
    return { count: needed.length, error: needed[0]?.[1] };
  }

  add(item: T, error: StreamError): void {
    this.#failed.delete(item);
    this.#failed.set(item, error);
    this.#timer ??= setTimeout(this.#retryNext, slowWait(this.#retries));
  }

  retryAll(): void {
    clearTimeout(this.#timer);
    this.#timer = undefined;
    this.#retries = 0;
    const items = [...this.#failed.keys()];
    this.#failed.clear();
    for (const item of items) this.#retry(item);
  }

  close(): void {
    clearTimeout(this.#timer);
    this.#failed.clear();
  }

  readonly #retryNext = (): void => {
    this.#timer = undefined;
    if (this.#failed.size === 0) return;
    this.#timer = setTimeout(this.#retryNext, slowWait(++this.#retries));
    for (const item of this.#failed.keys()) {
      if (!this.#isNeeded(item)) continue;
      this.#failed.delete(item);
      this.#retry(item);
      return;
    }
  };
}
