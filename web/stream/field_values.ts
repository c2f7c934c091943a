import type { Chunk } from "../core/records.ts";
import type { Bins, DecodedChunk, FieldInfo, StoreMetadata } from "../core/types.ts";
import { CoalescedTask } from "./coalesced_task.ts";
import { FieldBins } from "./field_bins.ts";
import { type FieldAccess, FieldLoader } from "./field_loader.ts";
import { StreamError, type StreamEvents } from "./types.ts";

export interface FieldValuesEvents {
  /** The chunk of a resident handle. */
  chunkOf(handle: number): Chunk | undefined;
  /** A field chunk, a page or the header of the field cannot be read, or the GPU has no room for values. */
  failed(error: StreamError, isFirst: boolean): void;
  changed(): void;
  /** The first values of the field that is shown are drawn from now on. */
  coloured(): void;
}

interface HeldChunk {
  chunk: Chunk;
  decoded: DecodedChunk;
  /** Passes the chunk on, with its values unless they are damaged. */
  release(decoded: DecodedChunk): void;
}

/** What a selection shows and needs. */
export interface DrawnSelection {
  /** The chunks that are drawn from now on, the most important first. */
  drawn: Uint32Array;
  /** The chunks that are needed and not resident, the most needed first. */
  load: readonly Chunk[];
  /** The isovalue moves: nothing is requested for it. */
  isMoving: boolean;
}

/**
 * The values of the field that is shown. A chunk that a view has requested is held until its values have arrived,
 * so that no surface is drawn without colours that have been drawn before. If the view no longer needs it, or the
 * source of the field does not respond, it is passed on without them. Other resident chunks get their values when
 * they are drawn.
 */
export class FieldValues {
  readonly #access: FieldAccess;
  readonly #viewer: StreamEvents;
  readonly #events: FieldValuesEvents;
  #loader: FieldLoader | undefined;
  readonly #held = new Map<number, HeldChunk>();
  /** The chunks on the GPU whose values are there too. */
  readonly #present = new Set<number>();
  /** Whether values of the field have been drawn. */
  #isColoured = false;
  #bins: FieldBins | undefined;
  #selection: DrawnSelection = { drawn: new Uint32Array(), load: [], isMoving: false };
  /** The handles of the chunks in `load`. */
  #awaited: ReadonlySet<number> = new Set();
  /** Why the GPU takes no more values, until `retry`. */
  #overflow: StreamError | undefined;
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

  /** The reason why the source does not respond to requests for the field, or why the GPU takes no values. */
  get trouble(): StreamError | undefined {
    return this.#overflow ?? this.#loader?.trouble;
  }

  /** Fetches the values of a field from now on, or of none. The viewer forgets those of another field. */
  show(field: FieldInfo | null): void {
    if (field?.name === this.shown?.name) return;
    this.#loader?.close();
    this.#loader = undefined;
    this.#present.clear();
    this.#isColoured = false;
    this.#overflow = undefined;
    this.#bins = field ? new FieldBins(field) : undefined;
    if (field) {
      this.#loader = new FieldLoader(this.#access, field, {
        samplesOf: (handle) => this.#samplesOf(handle),
        arrived: (handle, values) => this.#arrived(handle, values),
        failed: (error, isFirst) => this.#events.failed(error, isFirst),
        troubled: () => this.#releaseAll(),
        changed: () => this.#events.changed(),
      });
      this.#need();
    } else {
      this.#releaseAll();
    }
    this.#events.changed();
  }

  /** Whether the chunk is held until its values have arrived: not while the isovalue moves. */
  hold(chunk: Chunk, decoded: DecodedChunk, release: HeldChunk["release"]): boolean {
    if (!this.#loader || this.trouble) return false;
    if (this.#selection.isMoving || !this.#awaited.has(chunk.handle)) return false;
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

  /** While the isovalue moves, the requests for the last selection before go on. */
  draw(selection: DrawnSelection): void {
    this.#selection = selection;
    if (!this.#loader) return;
    this.#awaited = new Set(selection.load.map(({ handle }) => handle));
    for (const handle of [...this.#held.keys()]) {
      if (!this.#awaited.has(handle)) this.#release(handle);
    }
    if (!selection.isMoving) this.#need();
  }

  /** The field's description of itself; undefined until it is open. */
  get metadata(): StoreMetadata | undefined {
    return this.#loader?.metadata;
  }

  /** The range of the values on the surfaces that are drawn, without the lowest and highest `share`: FieldBins. */
  surfaceRange(share: number): [number, number] | undefined {
    return this.#bins?.percentiles([...this.#selection.drawn], share);
  }

  /** The labels around the surfaces that are drawn, if values are categories: FieldBins. */
  get labels(): ReadonlySet<number> {
    return this.#bins?.labels([...this.#selection.drawn]) ?? new Set();
  }

  /** How often values occur around the surfaces that are drawn: FieldBins. */
  get histogram(): Bins | undefined {
    return this.#bins?.histogram([...this.#selection.drawn]);
  }

  /** Passes the values of a chunk to the viewer, which has its samples. */
  upload(handle: number, values: Uint32Array): void {
    this.#bins?.add(handle, values, this.metadata?.categories !== undefined);
    this.#present.add(handle);
    this.#viewer.fieldValues?.(handle, values);
    if (!this.#isColoured) this.#events.coloured();
    this.#isColoured = true;
  }

  /** The chunk has left the GPU. */
  dropped(handle: number): void {
    this.#present.delete(handle);
    this.#bins?.remove(handle);
  }

  /** The GPU has no memory for the values of these chunks. None are requested until `retry`. */
  reject(handles: readonly number[], message: string): void {
    for (const handle of handles) this.dropped(handle);
    const isFirst = !this.#overflow;
    this.#overflow = new StreamError("out-of-memory", message);
    this.#loader?.need([]);
    this.#releaseAll();
    this.#events.failed(this.#overflow, isFirst);
  }

  /** Requests what has failed, and the values that did not fit into memory. */
  retry(): void {
    this.#overflow = undefined;
    this.#loader?.retry();
    this.#need();
  }

  close(): void {
    this.#needing.cancel();
    this.#loader?.close();
    this.#loader = undefined;
    this.#held.clear();
  }

  /** Passes a held chunk on. */
  #release(handle: number, values?: Uint32Array): void {
    const held = this.#held.get(handle);
    if (!held) return;
    this.#held.delete(handle);
    const info = this.shown;
    held.release(values && info ? { ...held.decoded, field: { info, values } } : held.decoded);
  }

  #releaseAll(): void {
    for (const handle of [...this.#held.keys()]) this.#release(handle);
  }

  #need(): void {
    if (this.#overflow) return;
    const { drawn, load } = this.#selection;
    const lacking = [...drawn]
      .filter((handle) => !this.#present.has(handle))
      .map((handle) => this.#events.chunkOf(handle))
      .filter((chunk) => chunk !== undefined);
    this.#loader?.need([...lacking, ...load.filter(({ handle }) => this.#held.has(handle))]);
  }

  #samplesOf(handle: number): Uint32Array | undefined {
    const held = this.#held.get(handle);
    if (held) return held.decoded.samples;
    return this.#events.chunkOf(handle) && this.#viewer.readSamples?.(handle);
  }

  #arrived(handle: number, values: Uint32Array | undefined): void {
    if (this.#held.has(handle)) this.#release(handle, values);
    else if (values && this.#events.chunkOf(handle)) this.upload(handle, values);
    if (values) this.#needing.request();
  }
}
