import type { Residency } from "./residency.ts";
import type { Source } from "./source.ts";
import type { Progress } from "./types.ts";

/** The shortest time between two reports of the same state (ms). */
const minInterval = 60;

/**
 * Reports progress. A new state is reported at once, and so is the arrival of the last missing
 * chunk or the need for another one. Changes of other numbers are reported at most once in
 * `minInterval`.
 */
export class ProgressReporter {
  readonly #current: () => Progress;
  readonly #report: (progress: Progress) => void;
  readonly #mark: (name: string) => void;
  #last = { text: "", state: "", hasArrived: true, at: 0 };
  #timer: ReturnType<typeof setTimeout> | undefined;

  /** `mark`: sets a mark on the browser's timeline. */
  constructor(
    current: () => Progress,
    report: (progress: Progress) => void,
    mark: (name: string) => void,
  ) {
    this.#current = current;
    this.#report = report;
    this.#mark = mark;
  }

  /** Something that Progress describes may have changed. */
  update(): void {
    const progress = this.#current();
    const text = JSON.stringify(progress);
    if (text === this.#last.text) return;
    const now = performance.now();
    const isNewState = progress.state !== this.#last.state;
    const hasArrived = progress.chunksToGo === 0;
    const isUrgent = isNewState || hasArrived !== this.#last.hasArrived;
    if (!isUrgent && now - this.#last.at < minInterval) {
      this.#timer ??= setTimeout(() => {
        this.#timer = undefined;
        this.update();
      }, minInterval);
      return;
    }
    if (isNewState && progress.state === "complete") this.#mark("isosplat:complete");
    if (isNewState && progress.state === "limited") this.#mark("isosplat:limited");
    this.#last = { text, state: progress.state, hasArrived, at: now };
    this.#report(progress);
  }

  close(): void {
    clearTimeout(this.#timer);
  }
}

/** Sets a mark on the browser's timeline, for benchmarks and developers: see README.md. */
export function markTimeline(name: string, source: Source, residency: Residency): void {
  const { name: volume, bytesReceived, requests } = source;
  const { samples: samplesResident, budget: sampleBudget } = residency;
  const detail = { volume, bytesReceived, requests, samplesResident, sampleBudget };
  // The browser keeps marks until they are cleared. One of each name is enough.
  performance.clearMarks?.(name);
  performance.mark?.(name, { detail });
}
