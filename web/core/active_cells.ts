import type { StoreInfo } from "./types.ts";

/** The part of a store's description that counts active cells. */
export type CellStatistics = Pick<StoreInfo, "metadata"> & {
  mapping: Pick<StoreInfo["mapping"], "scale">;
};

/**
 * Cells of the volume that are active at an isovalue, to within a bin of the store's statistics; if bins are
 * one quantized value wide, exactly. A cell is active from its least voxel up to its largest one, so an
 * isovalue between two quantized values has the count of the lower one. Undefined outside of the statistics.
 */
export function activeCellsAt(
  { metadata, mapping }: CellStatistics,
  isovalue: number,
): number | undefined {
  if (!metadata.active_cells) return undefined;
  const { low, high, counts } = metadata.active_cells;
  // The first bin begins half a step below its smallest quantized value. The division is not exact.
  const quantized = Math.floor((isovalue - low) / mapping.scale - 0.5 + 1e-6);
  const width = Math.round((high - low) / mapping.scale / counts.length);
  return counts[Math.floor(quantized / width)];
}
