import { faults, slowWait } from "./faults.ts";
import { TransferError } from "./transfer.ts";
import { StreamError } from "./types.ts";

const firstWait = 250;
const longestWait = 10_000;
/** After this many consecutive faults, the source counts as unreachable, and the viewer is informed. */
const faultsUntilOffline = 3;

export interface BackoffEvents {
  /**
   * Called with a fault that has lasted long enough to be reported; with undefined when the source
   * works again.
   */
  trouble(error: StreamError | undefined): void;
  /** A request failed with a fault that is retried slowly. Called for each failure. */
  slow?(error: StreamError): void;
}

/**
 * Decides when to retry a failed source (`Retry` in faults.ts). soon: after 1/4 s, doubled each time up
 * to 10 s, plus up to a quarter at random, so that many clients do not return at the same time. slowly:
 * see `slowWait`. If the server sends Retry-After, the wait is at least that long. When the browser is
 * online again, the source is retried at once. Until the source responds, there is only one request at
 * a time.
 */
export class Backoff {
  #faults = 0;
  #until = 0;
  #hasBeenHastened = false;
  #underway = 0;
  #trouble: StreamError | undefined;
  readonly #events: BackoffEvents;
  readonly #wake = new Set<() => void>();
  readonly #online = () => this.wake();

  constructor(events: BackoffEvents) {
    this.#events = events;
    if (typeof addEventListener === "function") addEventListener("online", this.#online);
  }

  /** The present fault: after `faultsUntilOffline` failures, or at once if it is retried slowly. */
  get trouble(): StreamError | undefined {
    return this.#trouble;
  }

  /** Whether requests have to wait now. */
  get waiting(): boolean {
    return this.#until > Date.now() || (this.#faults > 0 && this.#underway > 0);
  }

  /** Call this before a request, and the returned function when the request has ended. */
  begin(): () => void {
    ++this.#underway;
    let isOver = false;
    return () => {
      if (isOver) return;
      isOver = true;
      --this.#underway;
      this.#wakeAll();
    };
  }

  succeeded(): void {
    if (this.#faults === 0) return;
    this.#faults = 0;
    this.#until = 0;
    this.#hasBeenHastened = false;
    this.#setTrouble(undefined);
    this.#wakeAll();
  }

  failed(error: StreamError): void {
    const isSlow = faults[error.kind].retry !== "soon";
    const random = 1 + Math.random() / 4;
    const soon = Math.min(longestWait, firstWait * 2 ** this.#faults) * random;
    const wait = isSlow ? slowWait(this.#faults) : soon;
    const requestedWait = error instanceof TransferError ? error.retryAfter : 0;
    // Concurrent requests fail together. They count as one fault.
    if (this.#until <= Date.now()) ++this.#faults;
    this.#until = Math.max(this.#until, Date.now() + Math.max(wait, requestedWait));
    if (isSlow || this.#faults >= faultsUntilOffline) this.#setTrouble(error);
    if (isSlow) this.#events.slow?.(error);
  }

  /** Replaces the present fault by its cause. */
  explain(error: StreamError): void {
    if (this.#trouble) this.#setTrouble(error);
  }

  /**
   * Ends the wait, because the source seems to work. This happens only once until a request succeeds.
   * Otherwise a fault with another cause would be retried endlessly.
   */
  hasten(): void {
    if (this.#hasBeenHastened) return;
    this.#hasBeenHastened = true;
    this.wake();
  }

  wake(): void {
    this.#until = 0;
    this.#wakeAll();
  }

  #wakeAll(): void {
    for (const wake of [...this.#wake]) wake();
  }

  #setTrouble(error: StreamError | undefined): void {
    if (error?.kind === this.#trouble?.kind) return;
    this.#trouble = error;
    this.#events.trouble(error);
  }

  /** Resolves when a request may start; rejects with the signal's reason. */
  async ready(signal: AbortSignal): Promise<void> {
    while (this.waiting) {
      await new Promise<void>((resolve, reject) => {
        const done = (): void => {
          clearTimeout(timer);
          this.#wake.delete(done);
          signal.removeEventListener("abort", aborted);
          resolve();
        };
        const aborted = (): void => {
          done();
          reject(signal.reason);
        };
        const left = this.#until - Date.now();
        // Without a timer, the promise resolves when the request in flight ends.
        const timer = left > 0 ? setTimeout(done, left + 1) : undefined;
        this.#wake.add(done);
        signal.addEventListener("abort", aborted, { once: true });
      });
      signal.throwIfAborted();
    }
  }

  /**
   * Repeats an attempt until it succeeds, or fails with a fault that is not retried soon. With
   * `slowly`, it also repeats after faults that are retried slowly.
   */
  async retry<T>(
    signal: AbortSignal,
    attempt: () => Promise<T>,
    { slowly = false } = {},
  ): Promise<T> {
    for (;;) {
      await this.ready(signal);
      const ended = this.begin();
      try {
        const result = await attempt();
        this.succeeded();
        return result;
      } catch (error) {
        signal.throwIfAborted();
        if (!(error instanceof StreamError)) throw error;
        const { retry } = faults[error.kind];
        if (retry === "never" || (retry === "slowly" && !slowly)) throw error;
        this.failed(error);
      } finally {
        ended();
      }
    }
  }

  close(): void {
    if (typeof removeEventListener === "function") removeEventListener("online", this.#online);
  }
}
