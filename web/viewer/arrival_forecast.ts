/** Arrivals longer ago (ms) say little about the link's present rate. */
const span = 500;

/** Expects when the chunks of a view will be resident, from the rate of the last arrivals. */
export class ArrivalForecast {
  /** Payload bytes received until a time (ms), oldest first. */
  #received: { at: number; bytes: number }[] = [];
  #bytesToGo = 0;

  /** `bytesReceived`: since the volume was opened. `bytesToGo`: of the chunks that are missing. */
  add(now: number, bytesReceived: number, bytesToGo: number): void {
    this.#bytesToGo = bytesToGo;
    const begin = this.#received.findLastIndex(({ at }) => now - at >= span);
    this.#received = this.#received.slice(Math.max(0, begin));
    this.#received.push({ at: now, bytes: bytesReceived });
  }

  /** Another volume is opened. */
  forget(): void {
    this.#received = [];
    this.#bytesToGo = 0;
  }

  /** Milliseconds until everything has arrived; Infinity if nothing has arrived lately. */
  remaining(now: number): number {
    const [first] = this.#received;
    const last = this.#received.at(-1);
    if (!first || !last || last.bytes <= first.bytes) return Number.POSITIVE_INFINITY;
    return (this.#bytesToGo * Math.max(1, now - first.at)) / (last.bytes - first.bytes);
  }
}
