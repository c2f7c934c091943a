/**
 * Work starts when a view has been complete for this time (ms), so that it does not compete with a
 * gesture.
 */
const startDelay = 500;
/** After a fault, nothing is fetched for this time (ms), and then only when a view is complete. */
const faultPause = 12_000;

/**
 * Fetches data that no view needs yet, while a view is complete. A fault ends it silently: a view that
 * needs the same data requests them again, and reports the fault.
 */
export class IdleWork {
  readonly #ended: () => void;
  #running: AbortController | undefined;
  #notBefore = Number.NEGATIVE_INFINITY;
  #isClosed = false;

  /** `ended` is called when work has ended by itself, or by a fault. */
  constructor(ended: () => void) {
    this.#ended = ended;
  }

  get isRunning(): boolean {
    return this.#running !== undefined;
  }

  /** A view is complete: starts the work soon, unless it is running or a fault was recent. */
  start(work: (signal: AbortSignal) => Promise<void>): void {
    if (this.#isClosed || this.#running || performance.now() < this.#notBefore) return;
    const running = new AbortController();
    const { signal } = running;
    this.#running = running;
    void delay(startDelay, signal)
      .then(() => work(signal))
      .catch(() => {
        if (!signal.aborted) this.#notBefore = performance.now() + faultPause;
      })
      .finally(() => {
        if (this.#running !== running) return;
        this.#running = undefined;
        this.#ended();
      });
  }

  /** A view needs other data: cancels the work. */
  stop(): void {
    this.#running?.abort(new DOMException("a view needs other data", "AbortError"));
    this.#running = undefined;
  }

  /** The volume is closed: `ended` is not called any more. */
  close(): void {
    this.#isClosed = true;
    this.stop();
  }
}

function delay(milliseconds: number, signal: AbortSignal): Promise<void> {
  return new Promise((resolve, reject) => {
    const timer = setTimeout(resolve, milliseconds);
    signal.addEventListener("abort", () => {
      clearTimeout(timer);
      reject(signal.reason);
    });
  });
}
