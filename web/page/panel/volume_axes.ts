import type { StoreInfo } from "../../core/types.ts";
import { axisNames, isAnatomical } from "../../overlay/axis_names.ts";

/** The axes of a volume's grid. */
export const volumeAxes = ["x", "y", "z"] as const;

/** The cosine of 30°. */
const nearlyParallel = Math.sqrt(0.75);

/**
 * The anatomical sides of an axis's two ends, "R–L", where they are known and the axis is nearly theirs; undefined
 * elsewhere.
 */
export function sidesOf(axis: number, info: StoreInfo): string | undefined {
  if (!isAnatomical(info)) return undefined;
  const along = [0, 1, 2].map((row) => info.direction[3 * row + axis] ?? 0);
  const world = along.findIndex((part) => Math.abs(part) > nearlyParallel);
  const [low, high] = axisNames(info)[world] ?? [];
  if (low === undefined || high === undefined) return undefined;
  return (along[world] ?? 1) > 0 ? `${low}–${high}` : `${high}–${low}`;
}

/** The name of an axis, with its sides where they are known: "x, R–L". */
export function axisText(axis: number, info: StoreInfo): string {
  const name = volumeAxes[axis] ?? "";
  const sides = sidesOf(axis, info);
  return sides ? `${name}, ${sides}` : name;
}
