import type { Store } from "../core/core.ts";
import type { Chunk } from "../core/records.ts";

/**
 * The purpose of an upload: a camera view; the coarse levels, which stay resident as long as the volume
 * is open; or isovalues that may be shown later (BackgroundLoader).
 */
export type UploadPurpose = "view" | "coarse" | "advance";

interface Resident {
  chunk: Chunk;
  samples: number;
  /** Number of the last selection that used it; −1 if none did, because it was fetched in advance. */
  lastUse: number;
  pinned: boolean;
}

/**
 * The resident chunks, within the sample budget. Memory is reserved before a chunk is requested, by the
 * number of cells that the directory states. If the budget is used up, the least recently used chunks
 * are dropped, except those of the present view and pinned ones.
 */
export class Residency {
  #maxSamples: number;
  #budget: number;
  readonly #store: Store;
  readonly #dropped: (handle: number) => void;
  readonly #residents = new Map<number, Resident>();
  readonly #reserved = new Map<number, number>();
  #samples = 0;
  #pinnedSamples = 0;
  #reservedSamples = 0;
  #now = 0;

  constructor(store: Store, budget: number, dropped: (handle: number) => void) {
    this.#store = store;
    this.#maxSamples = budget;
    this.#budget = budget;
    this.#dropped = dropped;
  }

  /** The sample budget. */
  get budget(): number {
    return this.#budget;
  }

  /** Lowers the budget, but not below the pinned samples. */
  limit(samples: number): void {
    this.#budget = Math.max(this.#pinnedSamples, Math.min(this.#budget, Math.floor(samples)));
  }

  /**
   * Sets the sample budget. If more samples are resident, chunks are dropped as soon as no selection
   * uses them.
   */
  setBudget(samples: number): void {
    this.#maxSamples = samples;
    this.#budget = Math.max(this.#pinnedSamples, samples);
    this.#trim();
  }

  /** Undoes `limit`. */
  restoreBudget(): void {
    this.#budget = this.#maxSamples;
  }

  get chunks(): number {
    return this.#residents.size;
  }

  get samples(): number {
    return this.#samples;
  }

  get pinnedSamples(): number {
    return this.#pinnedSamples;
  }

  has(handle: number): boolean {
    return this.#residents.has(handle);
  }

  /** The chunk of a handle, if it is resident. */
  chunk(handle: number): Chunk | undefined {
    return this.#residents.get(handle)?.chunk;
  }

  /** The number of samples of the listed chunks. Chunks that are not resident have none. */
  samplesOf(handles: Uint32Array): number {
    return handles.reduce((sum, handle) => sum + (this.#residents.get(handle)?.samples ?? 0), 0);
  }

  /** Records that the present selection uses these chunks. */
  use(...lists: readonly Uint32Array[]): void {
    ++this.#now;
    for (const list of lists) {
      for (const handle of list) {
        const resident = this.#residents.get(handle);
        if (resident) resident.lastUse = this.#now;
      }
    }
    this.#trim();
  }

  /** Drops chunks that the present selection does not use, if the budget is exceeded. */
  #trim(): void {
    if (this.#samples + this.#reservedSamples <= this.#budget) return;
    for (const [handle] of this.#idle()) {
      if (this.#samples + this.#reservedSamples <= this.#budget) return;
      this.drop(handle);
    }
  }

  /** The chunks that may be dropped, the least recently used first. */
  #idle(): [number, Resident][] {
    return [...this.#residents]
      .filter(([, resident]) => !resident.pinned && resident.lastUse < this.#now)
      .sort(([, a], [, b]) => a.lastUse - b.lastUse);
  }

  /**
   * Reserves memory for a chunk. Returns false if dropping all unused chunks would not free enough.
   */
  reserve(chunk: Chunk): boolean {
    if (this.#reserved.has(chunk.handle)) return true;
    const room = (): number => this.#room(chunk);
    if (room() < 0) {
      const idle = this.#idle();
      const freeable = idle.reduce((samples, [, resident]) => samples + resident.samples, 0);
      if (room() + freeable < 0) return false;
      for (const [handle] of idle) {
        if (room() >= 0) break;
        this.drop(handle);
      }
    }
    this.#reserved.set(chunk.handle, chunk.cells);
    this.#reservedSamples += chunk.cells;
    return true;
  }

  /** Reserves memory for a chunk that no view needs, without dropping other chunks. */
  reserveFree(chunk: Chunk): boolean {
    return this.#room(chunk) >= 0 && this.reserve(chunk);
  }

  release(handle: number): void {
    this.#reservedSamples -= this.#reserved.get(handle) ?? 0;
    this.#reserved.delete(handle);
  }

  /** `purpose`: see UploadPurpose. Chunks fetched in advance are the first to be dropped. */
  add(chunk: Chunk, samples: number, purpose: UploadPurpose): void {
    const { handle } = chunk;
    this.release(handle);
    const pinned = purpose === "coarse";
    const lastUse = purpose === "advance" ? -1 : this.#now;
    this.#residents.set(handle, { chunk, samples, lastUse, pinned });
    this.#samples += samples;
    if (pinned) this.#pinnedSamples += samples;
    this.#store.setResident(handle, true);
  }

  #room(chunk: Chunk): number {
    return this.budget - this.#samples - this.#reservedSamples - chunk.cells;
  }

  drop(handle: number): void {
    if (this.lose(handle)) this.#dropped(handle);
  }

  /** Removes a chunk whose upload to the GPU failed. Returns whether it counted as resident. */
  lose(handle: number): boolean {
    const resident = this.#residents.get(handle);
    if (!resident) return false;
    this.#residents.delete(handle);
    this.#samples -= resident.samples;
    if (resident.pinned) this.#pinnedSamples -= resident.samples;
    this.#store.setResident(handle, false);
    return true;
  }

  dropAll(): void {
    for (const handle of [...this.#residents.keys()]) this.drop(handle);
  }
}
