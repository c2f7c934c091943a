import type { StoreInfo, Triple } from "../core/types.ts";
import type { SlicePlane, Slices } from "./types.ts";

export const noSlices: Slices = { along: [null, null, null] };

/** The slices that can be drawn. The object may come from scripts without types. */
export function usableSlices({ along, plane, range, mapped }: Partial<Slices>): Slices {
  const share = (axis: number) => {
    const at = along?.[axis];
    return Number.isFinite(at) ? Math.max(0, Math.min(1, at as number)) : null;
  };
  const usable: Slices = { along: [share(0), share(1), share(2)] };
  const numbers = [...(plane?.normal ?? []), plane?.offset];
  const isPlane = numbers.length === 4 && numbers.every(Number.isFinite);
  const size = isPlane && plane ? Math.hypot(...plane.normal) : 0;
  if (plane && size > 0 && Number.isFinite(size)) usable.plane = plane;
  const [low, high] = range ?? [];
  if (low !== undefined && high !== undefined && low < high && Number.isFinite(high - low)) {
    usable.range = [low, high];
  }
  if (mapped === true) usable.mapped = true;
  return usable;
}

export function hasSlices({ along, plane }: Slices): boolean {
  return plane !== undefined || along.some((share) => share !== null);
}

/** Whether slices have their defaults: no planes, no range of values, and greys. */
export function isDefaultSlices(slices: Slices): boolean {
  return !hasSlices(slices) && !slices.range && !slices.mapped;
}

/** The planes of all slices. */
export function slicePlanes({ along, plane }: Slices, info: StoreInfo): SlicePlane[] {
  const planes = along.map((share, axis) => share !== null && planeAcross(axis, share, info));
  return [...planes, plane].filter((each) => !!each);
}

/** The plane across an axis of the grid, which need not be perpendicular to the others. */
function planeAcross(axis: number, share: number, info: StoreInfo): SlicePlane {
  const { direction, origin, spacing, voxels } = info;
  const column = (i: number) => [0, 3, 6].map((row) => direction[row + (i % 3)] ?? 0) as Triple;
  const [a1, a2, a3] = column(axis + 1);
  const [b1, b2, b3] = column(axis + 2);
  const normal: Triple = [a2 * b3 - a3 * b2, a3 * b1 - a1 * b3, a1 * b2 - a2 * b1];
  const along = (v: readonly number[]) => normal.reduce((sum, n, i) => sum + n * (v[i] ?? 0), 0);
  const extent = (spacing[axis] ?? 0) * ((voxels[axis] ?? 1) - 1);
  return { normal, offset: along(origin) + share * extent * along(column(axis)) };
}
