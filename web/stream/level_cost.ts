import type { Store } from "../core/core.ts";
import type { Chunk } from "../core/records.ts";

/** The cost of surfaces at one level: all chunks that they need, from any view. */
export interface LevelCost {
  level: number;
  bytes: number;
  cells: number;
}

/** The cost of these isovalues at each level whose directory has been fetched. */
export function levelCosts(store: Store, isovalues: readonly number[]): LevelCost[] {
  return Array.from({ length: store.info.levels }, (_, level) => level).flatMap((level) => {
    const isKnown = isovalues.every((isovalue) => store.missingPages(level, isovalue).length === 0);
    return isKnown ? [costOf(level, chunksOf(store, level, isovalues))] : [];
  });
}

function chunksOf(store: Store, level: number, isovalues: readonly number[]): Chunk[] {
  const chunks = isovalues.flatMap((isovalue) => store.chunksFor(level, isovalue));
  return [...new Map(chunks.map((chunk) => [chunk.handle, chunk])).values()];
}

function costOf(level: number, chunks: readonly Chunk[]): LevelCost {
  const bytes = chunks.reduce((sum, chunk) => sum + chunk.bytes, 0);
  return { level, bytes, cells: chunks.reduce((sum, chunk) => sum + chunk.cells, 0) };
}
