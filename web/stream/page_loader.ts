import { CoreError } from "../core/calls.ts";
import type { Store } from "../core/core.ts";
import type { Page } from "../core/records.ts";
import type { Backoff } from "./backoff.ts";
import { badDirectory } from "./coarse_tail.ts";
import { FailedParts } from "./failed_parts.ts";
import type { Source } from "./source.ts";
import { measured } from "./timeline.ts";
import { StreamError } from "./types.ts";

/** Limit of pages in one request. */
const maxTogether = 32;

export interface PageEvents {
  added(): void;
  /** Like QueueEvents.failed, for a page. */
  failed(error: StreamError, isFirst: boolean): void;
}

/** Fetches directory pages, the most needed first, one request at a time. */
export class PageLoader {
  readonly #source: Source;
  readonly #store: Store;
  readonly #backoff: Backoff;
  readonly #signal: AbortSignal;
  readonly #events: PageEvents;
  readonly #pages: Page[];
  readonly #failed = new FailedParts<number>(
    (index) => this.#needed.includes(index),
    () => this.need(this.#needed),
  );
  /** Pages whose bytes did not match. They are fetched once more, bypassing the caches. */
  readonly #refused = new Set<number>();
  readonly #hasFailed = new Set<number>();
  #needed: readonly number[] = [];
  #loading = false;

  constructor(
    source: Source,
    store: Store,
    backoff: Backoff,
    signal: AbortSignal,
    events: PageEvents,
  ) {
    this.#source = source;
    this.#store = store;
    this.#backoff = backoff;
    this.#signal = signal;
    this.#events = events;
    this.#pages = store.pages();
  }

  /** The level that a page describes. */
  level(page: number): number {
    return this.#pages[page]?.level ?? 0;
  }

  /** The number of damaged pages that are needed, and the error of the first. */
  get damaged(): { count: number; error: StreamError | undefined } {
    return this.#failed.needed;
  }

  isDamaged(page: number): boolean {
    return this.#failed.has(page);
  }

  /** Requests damaged pages again. */
  retry(): void {
    this.#failed.retryAll();
  }

  close(): void {
    this.#failed.close();
  }

  /** Sets the missing pages, in order of need. */
  need(pages: readonly number[]): void {
    this.#needed = pages;
    if (!this.#loading && this.#next().length > 0) void this.#load();
  }

  #next(): Page[] {
    const pages: Page[] = [];
    for (const index of this.#needed) {
      const page = this.#pages[index];
      if (page && !page.resident && !this.#failed.has(index)) pages.push(page);
      if (pages.length === maxTogether) break;
    }
    return pages;
  }

  async #load(): Promise<void> {
    this.#loading = true;
    for (let pages = this.#next(); pages.length > 0; pages = this.#next()) {
      try {
        await this.#backoff.retry(
          this.#signal,
          () => {
            const missing = pages.filter((page) => !page.resident);
            return this.#source.pages(missing, this.#signal, (index, bytes) => {
              this.#add(index, bytes);
            });
          },
          { slowly: true },
        );
      } catch (error) {
        if (this.#signal.aborted) return;
        const reason = error instanceof StreamError ? error : badDirectory(error);
        for (const { index, resident } of pages) {
          if (!resident && !this.#failed.has(index)) this.#fail(index, reason);
        }
      }
      this.#events.added();
    }
    this.#loading = false;
  }

  /**
   * Adds a page to the directory. Bytes that do not match are fetched once more, bypassing the
   * caches.
   */
  #add(index: number, bytes: Uint8Array): void {
    const page = this.#pages[index];
    if (this.#signal.aborted || !page) return;
    try {
      measured("isosplat:streaming", () => this.#store.addPage(index, bytes));
    } catch (error) {
      if (!(error instanceof CoreError)) throw error;
      if (this.#refused.has(index)) this.#fail(index, badDirectory(error));
      this.#refused.add(index);
      this.#source.bypassCaches();
      return;
    }
    page.resident = true;
    this.#refused.delete(index);
    // The page had failed before. Now other failed pages may succeed as well.
    if (this.#hasFailed.delete(index)) this.#failed.retryAll();
  }

  #fail(index: number, error: StreamError): void {
    const isFirst = this.#failed.needed.count === 0 && !this.#hasFailed.has(index);
    this.#hasFailed.add(index);
    this.#failed.add(index, error);
    this.#events.failed(error, isFirst);
  }
}
