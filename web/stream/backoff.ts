import { TransferError } from "./transfer.ts";
import { StreamError } from "./types.ts";

const firstWait = 250;
const longestWait = 10_000;
/** Faults in a row after which the source counts as out of reach, and the viewer is told. */
const faultsUntilOffline = 3;

/**
 * When a source that failed is tried again: after 1/4 s, then twice as long each time, up to 10 s,
 * give or take a quarter so that many clients do not come back at once; or when the server said, if
 * that is later; or at once when the browser finds itself online again.
 */
export class Backoff {
  #faults = 0;
  #until = 0;
  #reported = false;
  readonly #report: (error: StreamError) => void;
  readonly #wake = new Set<() => void>();
  readonly #online = () => this.wake();

  constructor(report: (error: StreamError) => void) {
    this.#report = report;
    if (typeof addEventListener === "function") addEventListener("online", this.#online);
  }

  /** The source has failed several times in a row and has not answered since. */
  get offline(): boolean {
    return this.#faults >= faultsUntilOffline;
  }

  get waiting(): boolean {
    return this.#until > Date.now();
  }

  succeeded(): void {
    this.#faults = 0;
    this.#until = 0;
    this.#reported = false;
  }

  failed(error: StreamError): void {
    const random = 0.75 + Math.random() / 2;
    const wait = Math.min(longestWait, firstWait * 2 ** this.#faults) * random;
    const asked = error instanceof TransferError ? error.retryAfter : 0;
    // Requests that were under way together fail together: that is one fault.
    if (!this.waiting) {
      ++this.#faults;
      this.#until = Date.now() + Math.max(wait, asked);
    }
    if (this.offline && !this.#reported) {
      this.#reported = true;
      this.#report(error);
    }
  }

  /** Nothing is asked for until then, whatever the faults. */
  pause(milliseconds: number): void {
    this.#until = Math.max(this.#until, Date.now() + milliseconds);
  }

  wake(): void {
    this.#until = 0;
    for (const wake of [...this.#wake]) wake();
  }

  /** Resolves when the source may be tried; rejects with the signal's reason. */
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
        const timer = setTimeout(done, Math.max(1, this.#until - Date.now()));
        this.#wake.add(done);
        signal.addEventListener("abort", aborted, { once: true });
      });
      signal.throwIfAborted();
    }
  }

  /** Tries until it succeeds, or fails for a reason that trying again does not mend. */
  async retry<T>(signal: AbortSignal, attempt: () => Promise<T>): Promise<T> {
    for (;;) {
      await this.ready(signal);
      try {
        const result = await attempt();
        this.succeeded();
        return result;
      } catch (error) {
        signal.throwIfAborted();
        if (!(error instanceof StreamError) || !error.retrying) throw error;
        this.failed(error);
      }
    }
  }

  close(): void {
    if (typeof removeEventListener === "function") removeEventListener("online", this.#online);
  }
}
