import type { Chunk } from "../core/records.ts";

/**
 * Decides which chunks to request while the isovalue moves. A prefetched chunk stays requested until
 * the movement ends, although no view needs it yet. Otherwise the next frame would cancel it, and a
 * later frame would request it again.
 */
export class Prefetch {
  readonly #handles = new Set<number>();

  /**
   * The chunks to request: those `underway` that the view needs or that were prefetched, and those
   * `ahead`, which are prefetched now.
   */
  select(
    needed: readonly Chunk[],
    underway: Iterable<Chunk>,
    ahead: readonly Chunk[],
  ): readonly Chunk[] {
    const neededHandles = new Set(needed.map((chunk) => chunk.handle));
    const kept = [...underway].filter(
      ({ handle }) => neededHandles.has(handle) || this.#handles.has(handle),
    );
    for (const chunk of ahead) this.#handles.add(chunk.handle);
    return [...kept, ...ahead];
  }

  /** The movement has ended. */
  end(): void {
    this.#handles.clear();
  }
}
