import type { Chunk } from "../core/index.ts";

/**
 * What is asked for while the isovalue moves. What was prefetched stays asked for until the movement
 * is over, though no view needs it yet: it would else be cancelled by the next frame, and asked for
 * again when the isovalue comes there.
 */
export class Prefetch {
  readonly #handles = new Set<number>();

  /**
   * The chunks to ask for: of those `underway` what the view needs or what was prefetched, and those
   * `ahead`, which are prefetched now.
   */
  select(
    needed: readonly Chunk[],
    underway: Iterable<Chunk>,
    ahead: readonly Chunk[],
  ): readonly Chunk[] {
    const ofUse = new Set(needed.map((chunk) => chunk.handle));
    const kept = [...underway].filter(
      ({ handle }) => ofUse.has(handle) || this.#handles.has(handle),
    );
    for (const chunk of ahead) this.#handles.add(chunk.handle);
    return [...kept, ...ahead];
  }

  /** The movement is over. */
  end(): void {
    this.#handles.clear();
  }
}
