import type { StoreInfo, Triple } from "../stream/types.ts";
import type { SlicePlane, Slices } from "./types.ts";

export const noSlices: Slices = { along: [null, null, null] };

export function hasSlices({ along, plane }: Slices): boolean {
  return plane !== undefined || along.some((share) => share !== null);
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
