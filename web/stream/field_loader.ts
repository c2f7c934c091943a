import type { Core, Store } from "../core/core.ts";
import type { Chunk } from "../core/records.ts";
import type { FieldInfo, StoreMetadata } from "../core/types.ts";
import { ChunkQueue } from "./chunk_queue.ts";
import type { Decoder } from "./decoder.ts";
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
  readonly #queue: ChunkQueue<Uint32Array | undefined>;
  #open: { store: Store; pages: PageLoader } | undefined;
  #fault: StreamError | undefined;
  /** The chunks of the store whose values are needed, the most needed first. */
  #needed: readonly Chunk[] = [];
  /** The field chunks of chunks that were needed, by the handle of the store's chunk. */
  readonly #chunks = new Map<number, Chunk>();
  /** The missing pages that describe field chunks of needed chunks, by the handle of the store's chunk. */
  readonly #pages = new Map<number, number>();
  /** The handle of the store's chunk, by that of the field chunk. */
  readonly #owners = new Map<number, number>();

  constructor(access: FieldAccess, info: FieldInfo, events: FieldEvents) {
    this.info = info;
    this.#access = access;
    this.#events = events;
    this.#source = new FieldSource(access.store.source, info);
    this.#queue = new ChunkQueue(
      this.#source,
      { decode: (chunk, bytes, signal) => this.#decode(chunk, bytes, signal) },
      access.store.backoff,
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
    return {
      count: count + (pages?.count ?? 0) + Number(this.#fault !== undefined),
      error: this.#fault ?? pages?.error ?? error,
    };
  }

  /** Sets the chunks of the store whose values are needed, the most needed first. */
  need(chunks: readonly Chunk[]): void {
    this.#needed = chunks;
    this.#request();
  }

  /** Requests damaged parts again. */
  retry(): void {
    if (this.#fault) {
      this.#fault = undefined;
      void this.#openField();
    }
    this.#queue.retry();
    this.#open?.pages.retry();
  }

  close(): void {
    this.#closing.abort(new DOMException("another field is shown", "AbortError"));
    this.#queue.close();
    this.#open?.pages.close();
    this.#open?.store.close();
    this.#open = undefined;
  }

  async #openField(): Promise<void> {
    const { core, store: access } = this.#access;
    const signal = AbortSignal.any([this.#closing.signal, access.closed]);
    try {
      const store = await openStore(
        this.#source,
        (header) => core.openField(header),
        access.backoff,
        signal,
      );
      if (signal.aborted) {
        store.close();
        return;
      }
      const pages = new PageLoader(this.#source, store, access.backoff, signal, {
        added: () => this.#request(),
        failed: (error, isFirst) => this.#failed(error, isFirst),
      });
      this.#open = { store, pages };
      this.#request();
    } catch (error) {
      if (signal.aborted) return;
      const message = error instanceof Error ? error.message : String(error);
      // The store itself is sound.
      this.#fault = new StreamError("damaged-part", message, error);
      this.#failed(this.#fault, true);
    }
  }

  #request(): void {
    if (this.#fault) this.#reportDamaged();
    if (!this.#open) return;
    const { store, pages } = this.#open;
    const found: Chunk[] = [];
    this.#pages.clear();
    for (const chunk of this.#needed) {
      const { handle } = chunk;
      const own = this.#chunks.get(handle) ?? store.chunkAt(chunk);
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

  #decode(chunk: Chunk, bytes: Uint8Array, signal: AbortSignal): Promise<Uint32Array | undefined> {
    const owner = this.#owners.get(chunk.handle);
    const samples = owner === undefined ? undefined : this.#events.samplesOf(owner);
    if (!samples) return Promise.resolve(undefined);
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
    const own = this.#chunks.get(handle);
    if (own) return this.#queue.state(own.handle) === "failed";
    const page = this.#pages.get(handle);
    const isPageDamaged = page !== undefined && this.#open?.pages.isDamaged(page);
    return isPageDamaged || this.#fault !== undefined;
  }

  #bytesOf(handle: number): number {
    return this.#chunks.get(handle)?.bytes ?? 0;
  }
}
