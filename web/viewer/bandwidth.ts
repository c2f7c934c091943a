/** A measurement needs at least this time (ms) and this number of bytes. A smaller one would measure the round trip. */
const shortest = 200;
const fewestBytes = 64 * 1024;
/** The rate is the highest of this number of measurements. The others include waits for round trips and decoding. */
const measurements = 8;

/** Measures the rate at which bytes arrive while something is being fetched. */
export class Bandwidth {
  #since: { at: number; bytes: number } | undefined;
  #rates: number[] = [];

  /** Bytes per second; undefined until it has been measured. */
  get bytesPerSecond(): number | undefined {
    return this.#rates.length > 0 ? Math.max(...this.#rates) : undefined;
  }

  /**
   * now: in ms. bytes: received so far. isFetching: whether more have been requested; times in which
   * nothing was requested are not counted.
   */
  add(now: number, bytes: number, isFetching: boolean): void {
    const since = this.#since;
    if (since && bytes < since.bytes) this.#since = undefined;
    else if (since && now - since.at >= shortest && bytes - since.bytes >= fewestBytes) {
      this.#since = undefined;
      const rate = (1000 * (bytes - since.bytes)) / (now - since.at);
      this.#rates = [...this.#rates, rate].slice(-measurements);
    }
    if (!isFetching) this.#since = undefined;
    else this.#since ??= { at: now, bytes };
  }
}
