import type { Core } from "../core/core.ts";
import { loadCore } from "../core/load_core.ts";
import type { Chunk } from "../core/records.ts";
import type { StoreInfo } from "../core/types.ts";
import { Backoff } from "../stream/backoff.ts";
import { openStore } from "../stream/open_store.ts";
import type { StoreAccess } from "../stream/session_parts.ts";
import type { Source } from "../stream/source.ts";
import { StreamError } from "../stream/types.ts";
import type { GridBox } from "./types.ts";

/** Number of chunks in a request. */
const chunksTogether = 32;
/** Cells of a block along each axis (kBlockCells). */
const blockCells = 64;

/** Reads all chunks of an isovalue, independent of any view. None of them becomes resident. */
export class SurfaceReader {
  readonly #access: StoreAccess;
  readonly #end: () => void;

  /** `access`: of an open volume, StreamSession.access. */
  constructor(access: StoreAccess, end: () => void = () => {}) {
    this.#access = access;
    this.#end = end;
  }

  /**
   * Opens a separate store, which close() frees. A source that fails three times in a row ends the
   * reading with its error.
   */
  static async open(source: Source, signal: AbortSignal, core?: Core): Promise<SurfaceReader> {
    const ending = new AbortController();
    const backoff = new Backoff({ trouble: (error) => error && ending.abort(error) });
    try {
      const both = AbortSignal.any([signal, ending.signal]);
      const reader = core ?? (await loadCore());
      const store = await openStore(source, (header) => reader.openStore(header), backoff, both);
      return new SurfaceReader({ source, store, backoff, closed: ending.signal }, () => {
        backoff.close();
        store.close();
      });
    } catch (error) {
      backoff.close();
      throw error;
    }
  }

  get info(): StoreInfo {
    return this.#access.store.info;
  }

  quantizedIsovalue(isovalue: number): number {
    return this.#access.store.quantizedIsovalue(isovalue);
  }

  /**
   * The chunks that an isovalue needs at a level, ascending by z, then y, then x: those whose
   * blocks may have cells in the box. Fetches missing pages of the directory.
   */
  async chunksOf(
    isovalue: number,
    level: number,
    signal: AbortSignal,
    box?: GridBox,
  ): Promise<Chunk[]> {
    const { source, store, backoff, closed } = this.#access;
    const both = AbortSignal.any([signal, closed]);
    both.throwIfAborted();
    const missing = new Set(store.missingPages(level, isovalue));
    const pages = store.pages().filter(({ index }) => missing.has(index));
    if (pages.length > 0) {
      const found = new Map<number, Uint8Array>();
      await backoff.retry(both, () =>
        source.pages(pages, both, (index, bytes) => found.set(index, bytes)),
      );
      both.throwIfAborted();
      for (const [index, bytes] of found) store.addPage(index, bytes);
    }
    return store
      .chunksFor(level, isovalue)
      .filter((chunk) => chunk.cells > 0 && (!box || this.#touches(chunk, box)))
      .sort(({ block: [ax, ay, az] }, { block: [bx, by, bz] }) => az - bz || ay - by || ax - bx);
  }

  /**
   * Fetches chunks, and calls `arrived` for one after the other, in their order, while the next
   * ones are in flight. The bytes are not checked. Failed requests are repeated, like those of a
   * view. A chunk for which `arrived` resolves to false is damaged: it is fetched once more,
   * bypassing all caches. Rejects with a StreamError, the signal's reason, or the reason of
   * `arrived`.
   */
  async read(
    chunks: readonly Chunk[],
    signal: AbortSignal,
    arrived: (chunk: Chunk, bytes: Uint8Array) => Promise<boolean>,
  ): Promise<void> {
    const ending = new AbortController();
    const all = AbortSignal.any([signal, this.#access.closed, ending.signal]);
    const fetchGroup = (from: number) => {
      const group = this.#fetch(chunks.slice(from, from + chunksTogether), all);
      group.catch(() => {}); // reported when its turn comes
      return group;
    };
    try {
      let next = fetchGroup(0);
      for (let from = 0; from < chunks.length; from += chunksTogether) {
        const found = await next;
        next = fetchGroup(from + chunksTogether);
        for (const chunk of chunks.slice(from, from + chunksTogether)) {
          all.throwIfAborted();
          const bytes = found.get(chunk.handle);
          if (bytes && (await arrived(chunk, bytes))) continue;
          this.#access.source.bypassCaches();
          const again = (await this.#fetch([chunk], all)).get(chunk.handle);
          if (again && (await arrived(chunk, again))) continue;
          throw new StreamError(
            "damaged-part",
            `block ${chunk.block.join(".")} cannot be read, also past all caches: build the store again`,
          );
        }
      }
    } finally {
      ending.abort(new DOMException("the reading has ended", "AbortError"));
    }
  }

  close(): void {
    this.#end();
  }

  async #fetch(chunks: readonly Chunk[], signal: AbortSignal): Promise<Map<number, Uint8Array>> {
    const found = new Map<number, Uint8Array>();
    if (chunks.length === 0) return found;
    const { source, backoff } = this.#access;
    await backoff.retry(signal, () =>
      source.chunks(chunks, signal, ({ handle }, bytes) => found.set(handle, bytes.slice())),
    );
    signal.throwIfAborted();
    return found;
  }

  #touches({ block, level, blockCells: cells }: Chunk, { low, high }: GridBox): boolean {
    return block.every((index, axis) => {
      const begin = index * blockCells * 2 ** level;
      const end = begin + (cells[axis] ?? 0) * 2 ** level;
      const extent = (this.info.voxels[axis] ?? 1) - 1;
      const [from, to] = [low[axis] ?? 0, high[axis] ?? 1];
      return (from <= 0 || end > from * extent) && (to >= 1 || begin < to * extent);
    });
  }
}
