/** A measurement takes at least this time (ms). */
const shortest = 200;
/** The rate is the highest of so many measurements: the others wait for round trips and decoding. */
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
    else if (since && (now - since.at >= shortest || !isFetching))
      this.#measured(since, now, bytes);
    if (!isFetching) this.#since = undefined;
    else this.#since ??= { at: now, bytes };
  }

  #measured(since: { at: number; bytes: number }, now: number, bytes: number): void {
    this.#since = undefined;
    const seconds = (now - since.at) / 1000;
    // Few bytes in a short time measure the round trip, or a cache.
    if (bytes === since.bytes || 1000 * seconds < shortest / 2) return;
    this.#rates = [...this.#rates, (bytes - since.bytes) / seconds].slice(-measurements);
  }
}
