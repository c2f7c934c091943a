import type { StoreInfo } from "./types.ts";

/** Cells of the volume that are active at an isovalue, to within a bin of the store's statistics. */
export function activeCellsAt({ metadata }: StoreInfo, isovalue: number): number | undefined {
  if (!metadata.active_cells) return undefined;
  const { low, high, counts } = metadata.active_cells;
  if (!(isovalue >= low && isovalue <= high)) return undefined;
  const bin = Math.floor(((isovalue - low) / (high - low)) * counts.length);
  return counts[Math.min(bin, counts.length - 1)];
}
