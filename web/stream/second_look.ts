import { slowWait } from "./faults.ts";
import type { StreamError } from "./types.ts";

/**
 * What has failed although its source answers: damaged parts. One of them at a time is asked for
 * again after 12, 14, then every 16 s (`slowWait`), that which has not been for longest; once one
 * is whole, so are the others, perhaps: all are asked for.
 */
export class SecondLook<T> {
  /** The longest failed first. */
  readonly #failed = new Map<T, StreamError>();
  readonly #isNeeded: (item: T) => boolean;
  readonly #again: (item: T) => void;
  #timer: ReturnType<typeof setTimeout> | undefined;
  /** Since all were asked for. */
  #looks = 0;

  /** `again`: asks for an item; it is not a failed one any more. */
  constructor(isNeeded: (item: T) => boolean, again: (item: T) => void) {
    this.#isNeeded = isNeeded;
    this.#again = again;
  }

  has(item: T): boolean {
    return this.#failed.has(item);
  }

  /** What is needed of the failed, and why the first of it has failed. */
  get needed(): { count: number; error: StreamError | undefined } {
    const needed = [...this.#failed].filter(([item]) => this.#isNeeded(item));
    return { count: needed.length, error: needed[0]?.[1] };
  }

  add(item: T, error: StreamError): void {
    this.#failed.delete(item);
    this.#failed.set(item, error);
    this.#timer ??= setTimeout(this.#look, slowWait(this.#looks));
  }

  /** Whatever was wrong may be mended: all are asked for. */
  all(): void {
    clearTimeout(this.#timer);
    this.#timer = undefined;
    this.#looks = 0;
    const items = [...this.#failed.keys()];
    this.#failed.clear();
    for (const item of items) this.#again(item);
  }

  close(): void {
    clearTimeout(this.#timer);
    this.#failed.clear();
  }

  readonly #look = (): void => {
    this.#timer = undefined;
    if (this.#failed.size === 0) return;
    this.#timer = setTimeout(this.#look, slowWait(++this.#looks));
    for (const item of this.#failed.keys()) {
      if (!this.#isNeeded(item)) continue;
      this.#failed.delete(item);
      this.#again(item);
      return;
    }
  };
}
