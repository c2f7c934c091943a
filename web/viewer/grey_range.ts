import type { StoreInfo } from "../core/types.ts";

/** The share of voxels that are darker than black, and of those that are brighter than white. */
const outside = 0.005;

/**
 * The values that slices show as black and white, if neither the visitor nor the scene chooses: the values outside
 * of which 0.5 % of the voxels lie at either end, so that a few bright voxels do not darken the others. Voxels in
 * the fullest bin of the histogram, which are mostly background, do not count. Without a usable histogram: the
 * range of all values. `isosplat render` does the same: native/headless/grey_range.h.
 */
export function greyRange({
  range,
  metadata,
}: Pick<StoreInfo, "range" | "metadata">): [number, number] {
  const { low = 0, high = 0, counts: given } = metadata.histogram ?? {};
  const isUsable = Array.isArray(given) && given.every((count) => count >= 0);
  if (!isUsable || !(low < high)) return range;
  const counts = [...given];
  counts[counts.indexOf(Math.max(...counts))] = 0;
  const total = counts.reduce((sum, count) => sum + count, 0);
  const bin = (i: number) => counts[i] ?? 0;
  let first = 0;
  let last = counts.length - 1;
  for (let darker = bin(first); first < last && darker <= outside * total; ) darker += bin(++first);
  for (let brighter = bin(last); last > first && brighter <= outside * total; ) {
    brighter += bin(--last);
  }
  const width = (high - low) / counts.length;
  const from = Math.max(range[0], low + width * first);
  const to = Math.min(range[1], low + width * (last + 1));
  return total > 0 && from < to ? [from, to] : range;
}
