/** Arrivals before this time span (ms) say little about the link's present rate. */
const span = 500;
/** The first bytes after a pause are expected within this time (ms). */
const firstBytes = 100;
/** The picture waits for the last chunk if this chunk is expected within the duration of this many pictures. */
const picturesWaited = 3;
/** The longest such wait (ms). It can be longer only if one picture takes longer. */
const longestWait = 1000;

/** Forecasts when the chunks of a view will be resident, from the rate of the last arrivals. */
export class ArrivalForecast {
  /** Payload bytes received until a time (ms), oldest first. */
  #received: { at: number; bytes: number }[] = [];
  #bytesToGo = 0;
  /** The rate of the last arrivals in bytes per ms; 0 before the first ones. */
  #rate = 0;

  /** `bytesReceived`: since the volume was opened. `bytesToGo`: of the missing chunks. */
  add(now: number, bytesReceived: number, bytesToGo: number): void {
    // While nothing was missing, nothing could arrive.
    if (this.#bytesToGo === 0) this.#received = [];
    this.#bytesToGo = bytesToGo;
    const begin = this.#received.findLastIndex(({ at }) => now - at >= span);
    this.#received = this.#received.slice(Math.max(0, begin));
    this.#received.push({ at: now, bytes: bytesReceived });
    this.#rate = this.#rateUntil(now) || this.#rate;
  }

  /** Another volume is opened. */
  forget(): void {
    this.#received = [];
    this.#bytesToGo = 0;
    this.#rate = 0;
  }

  /** Milliseconds until everything has arrived; Infinity if nothing has arrived recently. */
  remaining(now: number): number {
    const rate = this.#rateUntil(now);
    if (rate > 0) return this.#bytesToGo / rate;
    const waited = now - (this.#received[0]?.at ?? now);
    if (this.#rate === 0 || waited > firstBytes) return Number.POSITIVE_INFINITY;
    return firstBytes - waited + this.#bytesToGo / this.#rate;
  }

  /**
   * Milliseconds for which a picture should wait for the last chunk; 0: draw the resident chunks
   * now. `pictureTakes`: the duration of a picture, in ms.
   */
  wait(now: number, pictureTakes: number): number {
    const longest = Math.max(pictureTakes, Math.min(picturesWaited * pictureTakes, longestWait));
    const remaining = this.remaining(now);
    return remaining < longest ? remaining : 0;
  }

  /** Bytes per ms since the oldest recent arrival; 0 if nothing has arrived since. */
  #rateUntil(now: number): number {
    const [first] = this.#received;
    const last = this.#received.at(-1);
    if (!first || !last || last.bytes <= first.bytes) return 0;
    return (last.bytes - first.bytes) / Math.max(1, now - first.at);
  }
}
