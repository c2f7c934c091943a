/** The counts of a replay, as the viewers see it. */

/** A request that has ended. */
export interface Answer {
  /** Undefined if the connection broke, or the client gave up before. */
  status: number | undefined;
  /** The proxy's X-Cache; undefined where the proxy caches nothing. */
  cache: string | undefined;
  bytes: number;
  /** The time from when the request was due until its last byte arrived (ms). */
  latency: number;
  /** The time from when the request was due until it was sent (ms). */
  late: number;
  isCancelled: boolean;
  /** The fault, if there is no status. */
  fault?: string;
}

export class Account {
  /** Answered by the cache. */
  hits = 0;
  /** Responses from the server: they were not in the cache, or must not be cached. */
  misses = 0;
  passed = 0;
  /** Requests that were refused for their rate (429), failed, or were cancelled before a response. */
  refused = 0;
  failed = 0;
  cancelled = 0;
  bytes = 0;
  hitBytes = 0;
  /** The number of failed requests by their end: a status, or a fault of the connection. */
  readonly faults = new Map<string, number>();
  readonly #latencies: number[] = [];
  readonly #late: number[] = [];

  get requests(): number {
    return this.hits + this.misses + this.passed + this.refused + this.failed + this.cancelled;
  }

  add({ status, cache, bytes, latency, late, isCancelled, fault }: Answer): void {
    this.bytes += bytes;
    this.#late.push(late);
    if (status === undefined) {
      if (isCancelled) ++this.cancelled;
      else this.#fail(fault ?? "no answer");
      return;
    }
    if (status === 429) ++this.refused;
    else if (status !== 200 && status !== 206) this.#fail(String(status));
    else if (cache === undefined) ++this.passed;
    else if (cache === "HIT") {
      ++this.hits;
      this.hitBytes += bytes;
    } else ++this.misses;
    if (!isCancelled) this.#latencies.push(latency);
  }

  #fail(fault: string): void {
    ++this.failed;
    this.faults.set(fault, (this.faults.get(fault) ?? 0) + 1);
  }

  /** The time within which this share of the responses was complete (ms). */
  latency(share: number): number {
    return quantile(this.#latencies, share);
  }

  /** The delay that this share of the requests did not exceed when they were sent (ms). */
  late(share: number): number {
    return quantile(this.#late, share);
  }
}

/** The smallest value that this share of all values does not exceed. */
export function quantile(values: readonly number[], share: number): number {
  const sorted = Float64Array.from(values).sort();
  return sorted[Math.max(0, Math.ceil(share * sorted.length) - 1)] ?? Number.NaN;
}
