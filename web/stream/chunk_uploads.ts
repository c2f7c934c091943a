import type { Chunk } from "../core/records.ts";
import type { DecodedChunk } from "../core/types.ts";
import type { FieldAccess } from "./field_loader.ts";
import { FieldValues } from "./field_values.ts";
import { Residency, type UploadPurpose } from "./residency.ts";
import { StreamError, type StreamEvents } from "./types.ts";
import { type Upload, UploadQueue } from "./upload_queue.ts";

/** After an upload failed, the budget becomes this share of the samples that are resident. */
const shareAfterOverflow = 0.75;

export interface ChunkUploadEvents {
  /** The chunks of one frame are uploaded, or the budget has changed. */
  changed(): void;
  /**
   * Chunks that no view needed when they were fetched have become resident, or there was no memory for
   * them.
   */
  uploadedInAdvance(): void;
  /** A part of the field that is shown cannot be read. `isFirst`: see QueueEvents.failed. */
  fieldFailed(error: StreamError, isFirst: boolean): void;
  /** The values of a field that are missing have changed. */
  fieldChanged(): void;
  /** See FieldValuesEvents.coloured. */
  coloured(): void;
  /** The GPU is out of memory. Called once until `retry`. */
  overflowed(error: StreamError): void;
}

/**
 * The chunks on the GPU: uploads decoded chunks, keeps to the sample budget, and lowers the budget when
 * the GPU is out of memory.
 */
export class ChunkUploads {
  readonly residency: Residency;
  readonly fields: FieldValues;
  readonly #queue: UploadQueue;
  /** Chunks fetched in advance. They neither delay a view nor prevent it from being complete. */
  readonly #advanceQueue: UploadQueue;
  readonly #viewer: StreamEvents;
  readonly #events: ChunkUploadEvents;
  /** Chunks that did not fit into GPU memory. They are not requested again until `retry`. */
  readonly #rejected = new Set<number>();
  #overflow: StreamError | undefined;

  constructor(
    access: FieldAccess,
    budget: number,
    viewer: StreamEvents,
    events: ChunkUploadEvents,
  ) {
    this.#viewer = viewer;
    this.#events = events;
    this.residency = new Residency(access.store.store, budget, (id) => {
      this.fields.dropped(id);
      viewer.drop(id);
    });
    this.fields = new FieldValues(access, viewer, {
      chunkOf: (handle) => this.residency.chunk(handle),
      failed: (error, isFirst) => events.fieldFailed(error, isFirst),
      changed: () => events.fieldChanged(),
      coloured: () => events.coloured(),
    });
    const upload: Upload = (chunk, decoded, purpose) => this.#upload(chunk, decoded, purpose);
    this.#queue = new UploadQueue(upload, () => events.changed());
    this.#advanceQueue = new UploadQueue(upload, () => events.uploadedInAdvance());
  }

  /** The error of the last failed upload, until `retry`. */
  get overflow(): StreamError | undefined {
    return this.#overflow;
  }

  /** Whether no chunk of a view or of the coarse levels waits for its upload. */
  get isEmpty(): boolean {
    return this.#queue.empty && !this.fields.isHolding;
  }

  isQueued(handle: number): boolean {
    return this.#queue.has(handle) || this.#advanceQueue.has(handle) || this.fields.isHeld(handle);
  }

  isRejected(handle: number): boolean {
    return this.#rejected.has(handle);
  }

  /** Resolves when everything added so far for this purpose has been uploaded. */
  drained(purpose: UploadPurpose): Promise<void> {
    return this.#queueFor(purpose).drained();
  }

  /** A chunk that a view has requested waits for the values of the field that is shown. */
  add(chunk: Chunk, decoded: DecodedChunk, purpose: UploadPurpose): void {
    const release = (whole: DecodedChunk): void =>
      this.#queueFor(purpose).add(chunk, whole, purpose);
    if (purpose !== "view" || !this.fields.hold(chunk, decoded, release)) release(decoded);
  }

  /**
   * Called when the GPU reports later that the upload of these chunks failed. Returns those that
   * counted as resident; the caller drops them after it has replaced them in the picture.
   */
  reject(ids: readonly number[], message: string): number[] {
    const lost = ids.filter((id) => this.residency.lose(id));
    for (const id of lost) this.fields.dropped(id);
    this.#overflowed(message, lost);
    return lost;
  }

  /** Forgets failed uploads: the whole budget is used again. */
  retry(): void {
    this.#overflow = undefined;
    this.#rejected.clear();
    this.residency.restoreBudget();
  }

  /** Drops waiting chunks. Resident chunks stay. */
  close(): void {
    this.fields.close();
    this.#queue.close();
    this.#advanceQueue.close();
  }

  #queueFor(purpose: UploadPurpose): UploadQueue {
    return purpose === "advance" ? this.#advanceQueue : this.#queue;
  }

  #upload(chunk: Chunk, { samples, clusters, field }: DecodedChunk, purpose: UploadPurpose): void {
    const { handle } = chunk;
    if (this.residency.has(handle)) {
      this.residency.release(handle);
    } else if (this.#viewer.samples(handle, chunk, samples, clusters)) {
      this.residency.add(chunk, samples.length / 4, purpose);
      // The values may be those of a field that is no longer shown.
      if (field && field.info === this.fields.shown) this.fields.upload(handle, field.values);
    } else {
      this.residency.release(handle);
      // All chunks of the picture are resident.
      if (purpose === "advance") return;
      this.#overflowed("the graphics card has no room for more samples", [handle]);
    }
  }

  #overflowed(message: string, ids: readonly number[]): void {
    for (const id of ids) this.#rejected.add(id);
    this.residency.limit(this.residency.samples * shareAfterOverflow);
    const isFirst = !this.#overflow;
    this.#overflow = new StreamError("out-of-memory", message);
    if (isFirst) this.#events.overflowed(this.#overflow);
    this.#events.changed();
  }
}
