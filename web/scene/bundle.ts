import type { Core } from "../core/core.ts";
import type { Source } from "../stream/source.ts";
import { joined } from "../stream/transfer.ts";
import { StreamError } from "../stream/types.ts";
import {
  type BundledFile,
  type BundleHeader,
  coarseBytesOf,
  parseBundleHeader,
} from "./bundle_header.ts";
import { MergedRanges } from "./merged_ranges.ts";

/** The file of a bundle: the members of a store's source that concern bytes. */
export interface BundleFile
  extends Pick<
    Source,
    "name" | "address" | "isLocal" | "concurrency" | "fresh" | "range" | "bypassCaches" | "forget"
  > {
  /** The first bytes: at least `count`, unless the file is shorter. */
  firstBytes(count: number, signal: AbortSignal): Promise<Uint8Array>;
  /** Called when the file was read again and has not changed. */
  isSame?(): void;
}

/** Size of the first request for a bundle. */
const firstBundleBytes = 64 * 1024;
/** Coarse parts are fetched together up to this size. */
const maxTogether = 32 * 1024 * 1024;
/** Parts are kept up to this size in all. */
const maxKept = 64 * 1024 * 1024;

/** A byte range of the bundle that is kept, because it contains parts of several stores. */
interface Part {
  offset: number;
  bytes: Promise<Uint8Array>;
  length: number;
}

/**
 * A bundle that is being read (shared/core/scene/BUNDLE.md): its header, and the coarse parts of its stores,
 * which are fetched together. It keeps the parts that were used last; others are fetched again when a store
 * needs them. A bundle that was replaced is read again.
 */
export class Bundle {
  readonly file: BundleFile;
  readonly #core: Core;
  readonly #maxKept: number;
  readonly #merged: MergedRanges;
  #header: Promise<BundleHeader> | null = null;
  /** In the order of their last use, the most recently used one last. */
  #parts: Part[] = [];
  #rereading: Promise<BundleHeader> | null = null;

  /** keptBytes: the largest size of all parts that are kept. One part is kept, however large it is. */
  constructor(file: BundleFile, core: Core, keptBytes = maxKept) {
    this.file = file;
    this.#maxKept = keptBytes;
    this.#core = core;
    this.#merged = new MergedRanges(file);
  }

  /** Reads the header, once. Rejects with a StreamError or the signal's reason. */
  async header(signal: AbortSignal): Promise<BundleHeader> {
    if (!this.#header) {
      // Several stores wait for the header, so the signal of one of them must not abort the request.
      const header = this.#readHeader(new AbortController().signal);
      this.#header = header;
      header.catch(() => {
        if (this.#header === header) this.#header = null;
      });
    }
    const header = await this.#header;
    signal.throwIfAborted();
    return header;
  }

  async #readHeader(signal: AbortSignal): Promise<BundleHeader> {
    const { file } = this;
    const first = await file.firstBytes(firstBundleBytes, signal);
    const found = parseBundleHeader(this.#core, first, file.name);
    if (typeof found !== "number") {
      this.#keep(0, first.length, Promise.resolve(first));
      return found;
    }
    const rest = await this.#read(first.length, found - first.length, signal);
    const header = parseBundleHeader(this.#core, joined([first, rest]), file.name);
    if (typeof header !== "number") return header;
    throw new StreamError("cut-short", `${file.name}: the header ends too early: copy it again`);
  }

  async #read(offset: number, bytes: number, signal: AbortSignal): Promise<Uint8Array> {
    const parts: Uint8Array[] = [];
    await this.file.range(offset, bytes, signal, (part) => parts.push(part.slice()));
    return joined(parts);
  }

  /** The store at a path. Rejects with a StreamError if the bundle, which may have been replaced, has none there. */
  async store(path: string, signal: AbortSignal): Promise<BundledFile> {
    const { stores } = await this.header(signal);
    const store = stores.get(path);
    if (store) return store;
    throw new StreamError("not-found", `${this.file.name}: expected the store ${path}, found none`);
  }

  /** Fetches the coarse parts of these stores with one request, and keeps them for the sources that read them next. */
  async fetchCoarse(paths: readonly string[], signal: AbortSignal): Promise<void> {
    const { stores } = await this.header(signal);
    const missing = paths
      .flatMap((path) => stores.get(path) ?? [])
      .filter((store) => !this.#partOf(store.coarseOffset, coarseBytesOf(store)));
    if (missing.length === 0) return;
    const begin = Math.min(...missing.map((store) => store.coarseOffset));
    const end = Math.max(...missing.map((store) => store.coarseOffset + coarseBytesOf(store)));
    if (end - begin > maxTogether) return;
    this.#keep(begin, end - begin, this.#read(begin, end - begin, new AbortController().signal));
  }

  #keep(offset: number, length: number, bytes: Promise<Uint8Array>): void {
    const part = { offset, length, bytes };
    this.#parts.push(part);
    for (let kept = this.keptBytes; kept > this.#maxKept && this.#parts.length > 1; ) {
      kept -= this.#parts.shift()?.length ?? 0;
    }
    // A source that needs these bytes then fetches them itself, and retries on faults.
    bytes.catch(() => {
      this.#parts = this.#parts.filter((each) => each !== part);
    });
  }

  /** The size of the kept parts, including those that are still being fetched. */
  get keptBytes(): number {
    return this.#parts.reduce((sum, { length }) => sum + length, 0);
  }

  #partOf(offset: number, bytes: number): Part | undefined {
    const found = this.#parts.find(
      (part) => offset >= part.offset && offset + bytes <= part.offset + part.length,
    );
    if (found) this.#parts = [...this.#parts.filter((part) => part !== found), found];
    return found;
  }

  /** A range of the bundle. Returns whether it came from the kept parts. */
  async range(
    offset: number,
    bytes: number,
    signal: AbortSignal,
    arrived: (part: Uint8Array, offset: number) => void,
  ): Promise<boolean> {
    const part = this.#partOf(offset, bytes);
    const kept = await part?.bytes.catch(() => undefined);
    signal.throwIfAborted();
    if (part && kept && kept.length === part.length) {
      arrived(kept.subarray(offset - part.offset, offset - part.offset + bytes), offset);
      return true;
    }
    await this.#merged.range(offset, bytes, signal, arrived);
    return false;
  }

  bypassCaches(): void {
    this.#parts = [];
    this.file.bypassCaches();
  }

  /** Reads the header of the present bundle again. Concurrent calls share one request. */
  reread(signal: AbortSignal): Promise<BundleHeader> {
    this.#rereading ??= this.#reread(signal).finally(() => {
      this.#rereading = null;
    });
    return this.#rereading;
  }

  async #reread(signal: AbortSignal): Promise<BundleHeader> {
    const before = await this.#header?.catch(() => null);
    this.#header = null;
    this.#parts = [];
    this.file.forget();
    const header = await this.header(signal);
    if (before?.checksum === header.checksum) this.file.isSame?.();
    return header;
  }
}
