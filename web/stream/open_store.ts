import { CoreError } from "../core/calls.ts";
import type { Store } from "../core/core.ts";
import type { Backoff } from "./backoff.ts";
import { faultOfStatus, isOfPart } from "./faults.ts";
import type { Source } from "./source.ts";
import { beginsAsStore } from "./transfer.ts";
import { StreamError } from "./types.ts";

/**
 * Fetches the header and opens the store by `open` (Core.openStore, Core.openField). A header that cannot be read is
 * fetched once more, at its full length and bypassing the caches, unless the first request already did so. Rejects
 * with a StreamError or the signal's reason.
 */
export async function openStore(
  source: Source,
  open: (header: Uint8Array) => Store,
  backoff: Backoff,
  signal: AbortSignal,
): Promise<Store> {
  let whole = source.fresh;
  for (;;) {
    const header = await backoff.retry(signal, () => source.header(signal, whole));
    let store: Store;
    try {
      store = open(header);
    } catch (error) {
      const status = error instanceof CoreError ? error.status : "internal";
      if (whole || status === "internal") throw headerError(source, header, status, error);
      // A truncated header needs more bytes. Any other error may come from a cache.
      if (status !== "truncated") source.bypassCaches();
      whole = true;
      continue;
    }
    const spacing = source.spacingOf?.(store.info);
    if (spacing) store.setSpacing(spacing);
    const [expected, found] = [store.info.fileBytes, source.fileBytes];
    if (found === undefined || found >= expected) return store;
    store.close();
    throw cutShort(source.name, expected, found);
  }
}

function headerError(
  source: Source,
  header: Uint8Array,
  status: string,
  error: unknown,
): StreamError {
  const message = `${source.name}: ${error instanceof Error ? error.message : String(error)}`;
  const kind = faultOfStatus(status) ?? "internal";
  if (isOfPart(kind)) return new StreamError("damaged-header", message, error);
  if (kind === "cut-short" && !beginsAsStore(header)) {
    return new StreamError("not-a-store", message, error);
  }
  return new StreamError(kind, message, error);
}

/** The file has fewer bytes than its header states. */
export function cutShort(name: string, expected: number, found: number): StreamError {
  return new StreamError(
    "cut-short",
    `${name}: expected ${expected} bytes, found ${found}: rebuild the store, or copy it again`,
  );
}
