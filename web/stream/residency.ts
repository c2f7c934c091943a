import type { Chunk, Store } from "../core/index.ts";

interface Resident {
  samples: number;
  /** When a selection last had a use for it. */
  useful: number;
  pinned: boolean;
}

/**
 * The chunks that the viewer holds, within the budget. Room is reserved for a chunk before it is
 * asked for, by what the directory says that it decodes to; where there is none, the chunk that has
 * been of no use for longest goes. What the present view uses stays, and so does what is pinned.
 */
export class Residency {
  readonly #maxSamples: number;
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

  /** Most samples held. */
  get budget(): number {
    return this.#budget;
  }

  /** Less than the budget has turned out to be possible; pinned samples stay. */
  limit(samples: number): void {
    this.#budget = Math.max(this.#pinnedSamples, Math.min(this.#budget, Math.floor(samples)));
  }

  /** All of the budget may be used again. */
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

  /** A selection uses these; all others have just become less useful. */
  use(...lists: readonly Uint32Array[]): void {
    ++this.#now;
    for (const list of lists) {
      for (const handle of list) {
        const resident = this.#residents.get(handle);
        if (resident) resident.useful = this.#now;
      }
    }
  }

  /** Makes room for a chunk and keeps it free. False: all that is held is in use. */
  reserve(chunk: Chunk): boolean {
    if (this.#reserved.has(chunk.handle)) return true;
    const room = (): number => this.budget - this.#samples - this.#reservedSamples - chunk.cells;
    if (room() < 0) {
      const idle = [...this.#residents]
        .filter(([, resident]) => !resident.pinned && resident.useful < this.#now)
        .sort(([, a], [, b]) => a.useful - b.useful);
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

  release(handle: number): void {
    this.#reservedSamples -= this.#reserved.get(handle) ?? 0;
    this.#reserved.delete(handle);
  }

  add(handle: number, samples: number, pinned: boolean): void {
    this.release(handle);
    this.#residents.set(handle, { samples, useful: this.#now, pinned });
    this.#samples += samples;
    if (pinned) this.#pinnedSamples += samples;
    this.#store.setResident(handle, true);
  }

  drop(handle: number): void {
    if (this.lose(handle)) this.#dropped(handle);
  }

  /** It has turned out not to be there. Answers whether it counted as resident. */
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
