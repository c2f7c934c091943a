import type { StoreInfo } from "../stream/index.ts";
import { formatBytes, formatCount } from "./format.ts";

/** Cells of the volume that are active at an isovalue, to within a bin of the store's statistics. */
export function activeCellsAt({ metadata }: StoreInfo, isovalue: number): number | undefined {
  if (!metadata.active_cells) return undefined;
  const { low, high, counts } = metadata.active_cells;
  if (!(isovalue >= low && isovalue <= high)) return undefined;
  const bin = Math.floor(((isovalue - low) / (high - low)) * counts.length);
  return counts[Math.min(bin, counts.length - 1)];
}

/** What an isovalue costs: "about 294 k cells, 400 KB at full detail". Empty if unknown. */
export function costText(cells: number | undefined, bytes: number | undefined): string {
  const parts = [
    ...(cells === undefined ? [] : [`about ${formatCount(cells)} active cells`]),
    ...(bytes === undefined ? [] : [`${formatBytes(bytes)} at full detail`]),
  ];
  return parts.join(", ");
}
