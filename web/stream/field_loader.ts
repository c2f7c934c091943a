import { CoreError } from "../core/calls.ts";
import type { Core, Store } from "../core/core.ts";
import type { Chunk } from "../core/records.ts";
import type { FieldInfo, StoreMetadata } from "../core/types.ts";
import { Backoff } from "./backoff.ts";
import { ChunkQueue } from "./chunk_queue.ts";
import type { Decoder } from "./decoder.ts";
import { slowWait } from "./faults.ts";
import { FieldSource } from "./field_source.ts";
import { openStore } from "./open_store.ts";
import { PageLoader } from "./page_loader.ts";
import type { RequestLimit } from "./request_limit.ts";
import type { StoreAccess } from "./session_parts.ts";
import { StreamError } from "./types.ts";

export interface FieldEvents {
  /** The samples of a chunk of the store; undefined if it is no longer resident. */
  samplesOf(handle: number): Uint32Array | undefined;
  /** The values for the samples of a chunk of the store. Undefined: they are damaged. */
  arrived(handle: number, values: Uint32Array | undefined): void;
  failed(error: StreamError, isFirst: boolean): void;
  /** The source does not respond, or responds again. */
  troubled(): void;
  changed(): void;
}

/** The parts of a session that a field shares with its store. */
export interface FieldAccess {
  core: Core;
  store: StoreAccess;
  decoder: Decoder;
  requests: RequestLimit | undefined;
}

/** Fetches and decodes the field chunks of chunks of the store. */
export class FieldLoader {
  readonly info: FieldInfo;
  readonly #source: FieldSource;
  readonly #access: FieldAccess;
  readonly #events: FieldEvents;
  readonly #closing = new AbortController();
  /** Of the field alone: its faults do not delay the store, whose bytes may be on this device. */
  readonly #backoff: Backoff;
  readonly #queue: ChunkQueue<Uint32Array | undefined>;
  #open: { store: Store; pages: PageLoader } | undefined;
  /** Why the field could not be opened. It is tried again later. */
  #fault: StreamError | undefined;
  #reopening: ReturnType<typeof setTimeout> | undefined;
  #failures = 0;
  /** Samples are read back one chunk after another, each in a task of its own. */
  #reading: Promise<unknown> = Promise.resolve();
  /** The chunks of the store whose values are needed, the most needed first. */
  #needed: readonly Chunk[] = [];
  /** The field chunks of chunks that were needed, by the handle of the store's chunk. */
  readonly #chunks = new Map<number, Chunk>();
  /** The missing pages that describe field chunks of needed chunks, by the handle of the store's chunk. */
  readonly #pages = new Map<number, number>();
  /** The handles of chunks that the field lacks. */
  readonly #missingIn = new Set<number>();
  /** The handle of the store's chunk, by that of the field chunk. */
  readonly #owners = new Map<number, number>();

  constructor(access: FieldAccess, info: FieldInfo, events: FieldEvents) {
    this.info = info;
    this.#access = access;
    this.#events = events;
    const pageBytes = access.store.store.pages().reduce((sum, { bytes }) => sum + bytes, 0);
    this.#source = new FieldSource(access.store.source, info, pageBytes);
    this.#backoff = new Backoff({ trouble: () => events.troubled() });
    this.#queue = new ChunkQueue(
      this.#source,
      { decode: (chunk, bytes, signal) => this.#decode(chunk, bytes, signal) },
      this.#backoff,
      {
        admit: () => true,
        released: () => {},
        decoded: (chunk, values) => this.#arrived(chunk, values),
        failed: (error, isFirst) => this.#failed(error, isFirst),
        changed: () => events.changed(),
      },
      access.requests,
    );
    void this.#openField();
  }

  /** The description of the field; undefined until it is open. */
  get metadata(): StoreMetadata | undefined {
    return this.#open?.store.info.metadata;
  }

  /** The reason why the source does not respond at present. */
  get trouble(): StreamError | undefined {
    return this.#backoff.trouble;
  }

  /** Chunks whose values are needed and can still arrive, and their bytes as far as they are known. */
  get missing(): { chunks: number; bytes: number } {
    if (this.#fault) return { chunks: 0, bytes: 0 };
    const chunks = this.#needed.filter(({ handle }) => !this.#hasFailed(handle));
    const bytes = chunks.reduce((sum, { handle }) => sum + this.#bytesOf(handle), 0);
    return { chunks: chunks.length, bytes };
  }

  /** The damaged chunks and pages that are needed, and the first error. */
  get damaged(): { count: number; error: StreamError | undefined } {
    const pages = this.#open?.pages.damaged;
    const { count, error } = this.#queue.damaged;
    const lacking = this.#needed.filter(({ handle }) => this.#missingIn.has(handle)).length;
    return {
      count: count + (pages?.count ?? 0) + lacking + Number(this.#fault !== undefined),
      error: this.#fault ?? pages?.error ?? error ?? (lacking > 0 ? this.#lack() : undefined),
    };
  }

  /** Sets the chunks of the store whose values are needed, the most needed first. */
  need(chunks: readonly Chunk[]): void {
    this.#needed = chunks;
    this.#request();
  }

  /** Requests damaged parts again. */
  retry(): void {
    this.#backoff.wake();
    this.#reopen();
    this.#queue.retry();
    this.#open?.pages.retry();
  }

  close(): void {
    this.#closing.abort(new DOMException("another field is shown", "AbortError"));
    clearTimeout(this.#reopening);
    this.#queue.close();
    this.#backoff.close();
    this.#open?.pages.close();
    try {
      this.#open?.store.close();
    } catch (error) {
      // The memory of an aborted instance is freed with the instance.
      if (!(error instanceof WebAssembly.RuntimeError)) throw error;
    }
    this.#open = undefined;
  }

  #reopen(): void {
    clearTimeout(this.#reopening);
    if (!this.#fault) return;
    this.#fault = undefined;
    void this.#openField();
  }

  async #openField(): Promise<void> {
    const { core, store: access } = this.#access;
    const signal = AbortSignal.any([this.#closing.signal, access.closed]);
    try {
      const open = (header: Uint8Array): Store => core.openField(header);
      const store = await openStore(this.#source, open, this.#backoff, signal);
      if (signal.aborted || !this.#belongsTo(store, access.store)) {
        store.close();
        signal.throwIfAborted();
        throw new StreamError(
          "damaged-part",
          `${this.#source.name}: expected the grid and the values of its store, found others: ` +
            "rebuild the store",
        );
      }
      const pages = new PageLoader(this.#source, store, this.#backoff, signal, {
        added: () => this.#request(),
        failed: (error, isFirst) => this.#failed(error, isFirst),
      });
      this.#open = { store, pages };
      this.#request();
    } catch (error) {
      if (signal.aborted) return;
      this.#couldNotOpen(error);
    }
  }

  /** A damaged header is a damaged part of a store that is sound itself. */
  #couldNotOpen(error: unknown): void {
    const message = error instanceof Error ? error.message : String(error);
    const kind = error instanceof StreamError ? error.kind : "damaged-part";
    const isOfPart = ["damaged-header", "not-a-store", "internal"].includes(kind);
    this.#fault = new StreamError(isOfPart ? "damaged-part" : kind, message, error);
    this.#reopening = setTimeout(() => this.#reopen(), slowWait(this.#failures));
    this.#failed(this.#fault, ++this.#failures === 1);
  }

  #belongsTo({ info }: Store, { info: of }: Store): boolean {
    const [own, expected] = [info, of].map(({ voxels, levels, quantizedRange, mapping }) =>
      JSON.stringify([voxels, levels, quantizedRange, mapping.offset, mapping.scale]),
    );
    return own === expected;
  }

  #request(): void {
    if (this.#fault) this.#reportDamaged();
    if (!this.#open) return;
    const { store, pages } = this.#open;
    const found: Chunk[] = [];
    this.#pages.clear();
    for (const chunk of this.#needed) {
      const { handle } = chunk;
      const own = this.#chunks.get(handle) ?? chunkAt(store, chunk);
      if (own === undefined) {
        this.#missingIn.add(handle);
        continue;
      }
      if (typeof own === "number") {
        this.#pages.set(handle, own);
        continue;
      }
      this.#chunks.set(handle, own);
      this.#owners.set(own.handle, handle);
      found.push(own);
    }
    pages.need([...new Set(this.#pages.values())]);
    this.#queue.need(found);
    this.#reportDamaged();
    this.#events.changed();
  }

  async #decode(
    chunk: Chunk,
    bytes: Uint8Array,
    signal: AbortSignal,
  ): Promise<Uint32Array | undefined> {
    const owner = this.#owners.get(chunk.handle);
    const before = this.#reading;
    const reading = (async () => {
      await before;
      await new Promise((resolve) => setTimeout(resolve));
      return owner === undefined || signal.aborted ? undefined : this.#events.samplesOf(owner);
    })();
    this.#reading = reading.catch(() => {});
    const samples = await reading;
    if (!samples) return undefined;
    const job = { ...chunk, field: { samples, bits: this.info.mapping.bits } };
    return this.#access.decoder.decodeField(job, bytes, signal);
  }

  #arrived({ handle }: Chunk, values: Uint32Array | undefined): void {
    const owner = this.#owners.get(handle);
    if (owner === undefined) return;
    this.#events.arrived(owner, values);
  }

  #failed(error: StreamError, isFirst: boolean): void {
    this.#reportDamaged();
    this.#events.failed(error, isFirst);
  }

  #reportDamaged(): void {
    for (const { handle } of this.#needed) {
      if (this.#hasFailed(handle)) this.#events.arrived(handle, undefined);
    }
  }

  #hasFailed(handle: number): boolean {
    if (this.#missingIn.has(handle)) return true;
    const own = this.#chunks.get(handle);
    if (own) return this.#queue.state(own.handle) === "failed";
    const page = this.#pages.get(handle);
    const isPageDamaged = page !== undefined && this.#open?.pages.isDamaged(page);
    return isPageDamaged || this.#fault !== undefined;
  }

  #lack(): StreamError {
    return new StreamError(
      "damaged-part",
      `${this.#source.name}: expected the chunks of its store, found some to be missing: rebuild the store`,
    );
  }

  #bytesOf(handle: number): number {
    return this.#chunks.get(handle)?.bytes ?? 0;
  }
}

/** The field chunk of a chunk of the store, the number of its page, or undefined if a malformed field lacks it. */
function chunkAt(store: Store, chunk: Chunk): Chunk | number | undefined {
  try {
    return store.chunkAt(chunk);
  } catch (error) {
    if (error instanceof CoreError && error.status === "not_found") return undefined;
    throw error;
  }
}
