import type { Chunk, DecodedChunk, Store } from "../core/index.ts";
import { Residency } from "./residency.ts";
import { StreamError, type StreamEvents } from "./types.ts";
import { UploadQueue } from "./upload_queue.ts";

/** After an upload failed, the budget becomes this share of the samples that are resident. */
const shareAfterOverflow = 0.75;

export interface ChunkUploadEvents {
  /** The chunks of one frame are uploaded, or the budget has changed. */
  changed(): void;
  /** The GPU has no room. Called once until `retry`. */
  overflowed(error: StreamError): void;
}

/**
 * The chunks on the GPU: uploads decoded chunks, keeps to the sample budget, and lowers the budget
 * when the GPU has no room.
 */
export class ChunkUploads {
  readonly residency: Residency;
  readonly #queue: UploadQueue;
  readonly #viewer: StreamEvents;
  readonly #events: ChunkUploadEvents;
  /** Chunks that the GPU had no room for. They are not requested again until `retry`. */
  readonly #rejected = new Set<number>();
  #overflow: StreamError | undefined;

  constructor(store: Store, budget: number, viewer: StreamEvents, events: ChunkUploadEvents) {
    this.#viewer = viewer;
    this.#events = events;
    this.residency = new Residency(store, budget, (id) => viewer.drop(id));
    this.#queue = new UploadQueue(
      (chunk, decoded, pinned) => this.#upload(chunk, decoded, pinned),
      () => events.changed(),
    );
  }

  /** The error of the last failed upload, until `retry`. */
  get overflow(): StreamError | undefined {
    return this.#overflow;
  }

  /** No chunk waits for its upload. */
  get isEmpty(): boolean {
    return this.#queue.empty;
  }

  isQueued(handle: number): boolean {
    return this.#queue.has(handle);
  }

  isRejected(handle: number): boolean {
    return this.#rejected.has(handle);
  }

  /** Resolves when everything added so far has been uploaded. */
  drained(): Promise<void> {
    return this.#queue.drained();
  }

  /** `pinned`: resident as long as the volume is open. */
  add(chunk: Chunk, decoded: DecodedChunk, pinned: boolean): void {
    this.#queue.add(chunk, decoded, pinned);
  }

  /**
   * The GPU reports later that it does not have these chunks. Returns those that counted as
   * resident: the caller drops them after it has replaced them in the picture.
   */
  reject(ids: readonly number[], message: string): number[] {
    const lost = ids.filter((id) => this.residency.lose(id));
    this.#overflowed(message, lost);
    return lost;
  }

  /** Forgets failed uploads: the whole budget is used again. */
  retry(): void {
    this.#overflow = undefined;
    this.#rejected.clear();
    this.residency.restoreBudget();
  }

  /** Drops what waits. Resident chunks stay. */
  close(): void {
    this.#queue.close();
  }

  #upload(chunk: Chunk, { samples, clusters }: DecodedChunk, pinned: boolean): void {
    const { handle } = chunk;
    if (this.residency.has(handle)) {
      this.residency.release(handle);
    } else if (this.#viewer.samples(handle, chunk, samples, clusters)) {
      this.residency.add(handle, samples.length / 4, pinned);
    } else {
      this.residency.release(handle);
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
