/** Calculates the results of caches of any size for the same requests. */
import type { PlannedVisit, RecordedRequest } from "./requests.ts";

/** Bytes of the pieces in which nginx fetches and keeps a store's file (native/packaging/nginx.conf). */
const slice = 1 << 20;

/** Paths of content that never changes and may be kept for ever. */
const kept = /^\/(assets\/|v1\/volumes\/[^/]+\/[0-9a-f]{32}\/(?!thumbnail\.webp))/;

export interface Item {
  /** The key of the cache entry. */
  key: string;
  /** The size of the entry. */
  bytes: number;
}

/** The entries of a cache that answer a request; none if it must not be kept. */
export function itemsOf({ path, range, encoding, bytes }: RecordedRequest): Item[] {
  if (!kept.test(path)) return [];
  const [, first, last] = /^bytes=(\d+)-(\d+)$/.exec(range ?? "") ?? [];
  if (!first || !last) return [{ key: encoding ? `${path} ${encoding}` : path, bytes }];
  const [begin, end] = [first, last].map((byte) => Math.floor(Number(byte) / slice));
  return Array.from({ length: (end ?? 0) - (begin ?? 0) + 1 }, (_, i) => ({
    key: `${path} ${(begin ?? 0) + i}`,
    bytes: slice,
  }));
}

/** A cache that drops the least recently used entries (LRU). */
export class LruCache {
  readonly #capacity: number;
  /** Sizes by key, the least recently used first. */
  readonly #entries = new Map<string, number>();
  #bytes = 0;

  constructor(capacity: number) {
    this.#capacity = capacity;
  }

  get bytes(): number {
    return this.#bytes;
  }

  get entries(): number {
    return this.#entries.size;
  }

  /**
   * Uses an entry. Returns whether the cache has it; if not, adds it, unless it is larger than the
   * cache.
   */
  use(key: string, bytes: number): boolean {
    const isThere = this.#entries.delete(key);
    if (!isThere) this.#bytes += bytes;
    this.#entries.set(key, bytes);
    for (const [oldest, size] of this.#entries) {
      if (this.#bytes <= this.#capacity) break;
      this.#entries.delete(oldest);
      this.#bytes -= size;
    }
    return isThere;
  }
}

/** All requests of all visits in the order of their times. */
export function inOrder(visits: readonly PlannedVisit[]): RecordedRequest[] {
  return visits
    .flatMap(({ at, visit }) => visit.requests.map((request) => ({ at: at + request.at, request })))
    .sort((a, b) => a.at - b.at)
    .map(({ request }) => request);
}

export interface Outcome {
  requests: number;
  bytes: number;
  /** Number of requests for which no entry had to be fetched. */
  hits: number;
  hitBytes: number;
  /** Bytes fetched from the server. */
  fetchedBytes: number;
  /** Number of entries at the end. */
  entries: number;
  cacheBytes: number;
}

/** Simulates a cache that keeps at most `capacity` bytes. An entry takes `sizeOf` of its body. */
export function simulate(
  requests: readonly RecordedRequest[],
  capacity: number,
  sizeOf: (bytes: number) => number = (bytes) => bytes,
): Outcome {
  const cache = new LruCache(capacity);
  let [bytes, hits, hitBytes, fetchedBytes] = [0, 0, 0, 0];
  const items = new Map<RecordedRequest, Item[]>();
  for (const request of requests) {
    bytes += request.bytes;
    let needed = items.get(request);
    if (!needed) {
      needed = itemsOf(request).map((item) => ({ ...item, bytes: item.bytes }));
      items.set(request, needed);
    }
    if (needed.length === 0) {
      fetchedBytes += request.bytes;
      continue;
    }
    let isHit = true;
    for (const item of needed) {
      if (cache.use(item.key, sizeOf(item.bytes))) continue;
      fetchedBytes += item.bytes;
      isHit = false;
    }
    if (!isHit) continue;
    ++hits;
    hitBytes += request.bytes;
  }
  return {
    requests: requests.length,
    bytes,
    hits,
    hitBytes,
    fetchedBytes,
    entries: cache.entries,
    cacheBytes: cache.bytes,
  };
}

/**
 * The share of the bytes of each visit that no other visit requests. A further visitor, unlike all
 * others, would miss this share in a cache with all requests of the others. Content that must not
 * be kept does not count.
 */
export function newShares(visits: readonly { requests: readonly RecordedRequest[] }[]): number[] {
  const itemsOfVisits = visits.map(
    ({ requests }) =>
      new Map(requests.flatMap(itemsOf).map(({ key, bytes }) => [key, bytes] as const)),
  );
  const users = new Map<string, number>();
  for (const items of itemsOfVisits) {
    for (const key of items.keys()) users.set(key, (users.get(key) ?? 0) + 1);
  }
  return itemsOfVisits.map((items) => {
    let [all, alone] = [0, 0];
    for (const [key, bytes] of items) {
      all += bytes;
      if (users.get(key) === 1) alone += bytes;
    }
    return all > 0 ? alone / all : 0;
  });
}
