import type { Chunk } from "../core/records.ts";
import type { DecodedChunk, FieldInfo, StoreMetadata } from "../core/types.ts";
import { CoalescedTask } from "./coalesced_task.ts";
import { FieldBins } from "./field_bins.ts";
import { type FieldAccess, FieldLoader } from "./field_loader.ts";
import type { StreamError, StreamEvents } from "./types.ts";

export interface FieldValuesEvents {
  /** The chunk of a resident handle. */
  chunkOf(handle: number): Chunk | undefined;
  /** A field chunk, a page or the header of the field cannot be read. */
  failed(error: StreamError, isFirst: boolean): void;
  changed(): void;
}

interface HeldChunk {
  chunk: Chunk;
  decoded: DecodedChunk;
  /** Passes the chunk on, with its values unless they are damaged. */
  release(decoded: DecodedChunk): void;
}

/**
 * The values of the field that is shown. A chunk that a view has requested is held until its values have arrived,
 * so that no surface is drawn without colours that have been drawn before. Other resident chunks get their values
 * when they are drawn.
 */
export class FieldValues {
  readonly #access: FieldAccess;
  readonly #viewer: StreamEvents;
  readonly #events: FieldValuesEvents;
  #loader: FieldLoader | undefined;
  readonly #held = new Map<number, HeldChunk>();
  /** The chunks on the GPU whose values are there too. */
  readonly #present = new Set<number>();
  #bins: FieldBins | undefined;
  #drawn: readonly number[] = [];
  readonly #needing = new CoalescedTask(() => this.#need());

  constructor(access: FieldAccess, viewer: StreamEvents, events: FieldValuesEvents) {
    this.#access = access;
    this.#viewer = viewer;
    this.#events = events;
  }

  /** The field that is shown. */
  get shown(): FieldInfo | null {
    return this.#loader?.info ?? null;
  }

  /** Chunks whose values are needed and can still arrive, and their bytes. */
  get missing(): { chunks: number; bytes: number } {
    return this.#loader?.missing ?? { chunks: 0, bytes: 0 };
  }

  get damaged(): { count: number; error: StreamError | undefined } {
    return this.#loader?.damaged ?? { count: 0, error: undefined };
  }

  /** Fetches the values of a field from now on, or of none. The viewer forgets those of another field. */
  show(field: FieldInfo | null): void {
    if (field?.name === this.shown?.name) return;
    this.#loader?.close();
    this.#loader = undefined;
    this.#present.clear();
    this.#bins = field ? new FieldBins(field) : undefined;
    if (field) {
      this.#loader = new FieldLoader(this.#access, field, {
        samplesOf: (handle) => this.#samplesOf(handle),
        arrived: (handle, values) => this.#arrived(handle, values),
        failed: (error, isFirst) => this.#events.failed(error, isFirst),
        changed: () => this.#events.changed(),
      });
      this.#need();
    } else {
      for (const { decoded, release } of this.#takeHeld()) release(decoded);
    }
    this.#events.changed();
  }

  /** Whether the chunk is held until its values have arrived. */
  hold(chunk: Chunk, decoded: DecodedChunk, release: HeldChunk["release"]): boolean {
    if (!this.#loader) return false;
    this.#held.set(chunk.handle, { chunk, decoded, release });
    this.#needing.request();
    return true;
  }

  /** Whether any chunk is held. */
  get isHolding(): boolean {
    return this.#held.size > 0;
  }

  isHeld(handle: number): boolean {
    return this.#held.has(handle);
  }

  /** These chunks are drawn from now on, the most important first. */
  draw(handles: Uint32Array): void {
    this.#drawn = [...handles];
    if (this.#loader) this.#need();
  }

  /** The field's description of itself; undefined until it is open. */
  get metadata(): StoreMetadata | undefined {
    return this.#loader?.metadata;
  }

  /** The range of the values on the surfaces that are drawn, without the lowest and highest `share`: FieldBins. */
  surfaceRange(share: number): [number, number] | undefined {
    return this.#bins?.percentiles(this.#drawn, share);
  }

  /** Passes the values of a chunk to the viewer, which has its samples. */
  upload(handle: number, values: Uint32Array): void {
    this.#bins?.add(handle, values);
    this.#present.add(handle);
    this.#viewer.fieldValues?.(handle, values);
  }

  /** The chunk has left the GPU. */
  dropped(handle: number): void {
    this.#present.delete(handle);
    this.#bins?.remove(handle);
  }

  retry(): void {
    this.#loader?.retry();
  }

  close(): void {
    this.#needing.cancel();
    this.#loader?.close();
    this.#loader = undefined;
    this.#held.clear();
  }

  #takeHeld(): HeldChunk[] {
    const held = [...this.#held.values()];
    this.#held.clear();
    return held;
  }

  #need(): void {
    const drawn = this.#drawn
      .filter((handle) => !this.#present.has(handle))
      .map((handle) => this.#events.chunkOf(handle))
      .filter((chunk) => chunk !== undefined);
    this.#loader?.need([...drawn, ...[...this.#held.values()].map(({ chunk }) => chunk)]);
  }

  #samplesOf(handle: number): Uint32Array | undefined {
    const held = this.#held.get(handle);
    if (held) return held.decoded.samples;
    return this.#events.chunkOf(handle) && this.#viewer.readSamples?.(handle);
  }

  #arrived(handle: number, values: Uint32Array | undefined): void {
    const held = this.#held.get(handle);
    if (held) {
      this.#held.delete(handle);
      const info = this.shown;
      held.release(values && info ? { ...held.decoded, field: { info, values } } : held.decoded);
    } else if (values && this.#events.chunkOf(handle)) {
      this.upload(handle, values);
    }
    if (values) this.#needing.request();
  }
}
