import type { Store } from "../core/core.ts";
import type { Chunk, Page } from "../core/records.ts";
import { PartError, type Source } from "./source.ts";
import { StreamError } from "./types.ts";

/** Number of concurrent requests for data that no view needs yet. */
const maxConcurrency = 4;

/** Bytes fetched for other isovalues so far, and bytes planned in all. */
export interface Preparation {
  bytes: number;
  bytesPlanned: number;
}

/** The directory pages of a level that have not been fetched. */
export function missingPages(store: Store, level: number): Page[] {
  const missing = new Set(store.missingPages(level, ...store.info.range));
  return missing.size === 0 ? [] : store.pages().filter(({ index }) => missing.has(index));
}

/** Fetches pages, and adds them to the directory. Rejects with the fault of the source or of a page. */
export async function addPages(
  source: Source,
  store: Store,
  pages: readonly Page[],
  signal: AbortSignal,
): Promise<void> {
  const arrived = new Map<number, Uint8Array>();
  await source.pages(pages, signal, (index, page) => arrived.set(index, page));
  signal.throwIfAborted();
  for (const [index, page] of arrived) store.addPage(index, page);
}

/**
 * Fetches chunks in the groups that their source forms, several at a time. `fetch` fetches a group, and
 * returns false to end early. Returns whether all chunks are fetched.
 */
export async function fetchInGroups(
  source: Source,
  chunks: readonly Chunk[],
  isFetched: (chunk: Chunk) => boolean,
  fetch: (group: readonly Chunk[]) => Promise<boolean>,
): Promise<boolean> {
  let rest = chunks;
  while (rest.length > 0) {
    const groups = source.group(rest);
    let goesOn = true;
    const fetchNext = async (): Promise<void> => {
      for (let group = groups.shift(); group && goesOn; group = groups.shift()) {
        goesOn = (await fetch(group)) && goesOn;
      }
    };
    const concurrency = Math.min(maxConcurrency, source.concurrency);
    await Promise.all(Array.from({ length: concurrency }, fetchNext));
    // A source may return groups that do not cover all chunks.
    const left = rest.filter((chunk) => !isFetched(chunk));
    if (!goesOn || left.length === rest.length) return goesOn && left.length === 0;
    rest = left;
  }
  return true;
}

/** The handle of the chunk that a request for `chunks` found damaged. Throws any other error. */
export function damagedChunk(chunks: readonly Chunk[], error: unknown): number {
  if (error instanceof PartError) return error.handle;
  const [first] = chunks;
  const isDamaged = error instanceof StreamError && error.kind === "damaged-part";
  if (first && chunks.length === 1 && isDamaged) return first.handle;
  throw error;
}

/** The distance of a chunk's band from an isovalue, in quantized values: negative if the band is below. */
export function bandDistance({ bandBegin, bandEnd }: Chunk, isovalue: number): number {
  return Math.max(bandBegin - isovalue, 0) + Math.min(bandEnd - isovalue, 0);
}
