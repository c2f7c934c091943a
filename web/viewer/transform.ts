import type { StoreInfo, Triple } from "../core/types.ts";
import { cross, dot } from "./vectors.ts";

/**
 * An affine transform of a store's world into that of the scene: a matrix of 4 × 4, row by row, whose last
 * row is 0 0 0 1.
 */
export type Transform = readonly number[];

export const identity: Transform = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];

/** The least volume of the transformed unit cube, relative to a box with perpendicular edges of the same lengths. */
const flattest = 1e-6;

/** Throws a RangeError unless these are the numbers of an affine transform that does not make volumes flat. */
export function checkedTransform(numbers: Transform): Transform {
  const isAffine =
    numbers.length === 16 &&
    numbers.every(Number.isFinite) &&
    [0, 0, 0, 1].every((number, i) => numbers[12 + i] === number);
  if (!isAffine) {
    throw new RangeError("a transform has 16 finite numbers, row by row, the last row 0 0 0 1");
  }
  const [a, b, c] = columnsOf(numbers);
  const volume = volumeScaleOf(numbers);
  const edges = Math.hypot(...a) * Math.hypot(...b) * Math.hypot(...c);
  if (!(volume > flattest * edges)) {
    throw new RangeError("a transform must not make volumes flat");
  }
  return [...numbers];
}

function columnsOf(transform: Transform): [Triple, Triple, Triple] {
  return [columnOf(transform, 0), columnOf(transform, 1), columnOf(transform, 2)];
}

function columnOf(transform: Transform, axis: number): Triple {
  return [transform[axis] ?? 0, transform[4 + axis] ?? 0, transform[8 + axis] ?? 0];
}

/** The linear part of the transform, applied to a direction. */
function turned(transform: Transform, v: Triple): Triple {
  const row = (i: number): Triple => [
    transform[4 * i] ?? 0,
    transform[4 * i + 1] ?? 0,
    transform[4 * i + 2] ?? 0,
  ];
  return [dot(row(0), v), dot(row(1), v), dot(row(2), v)];
}

export function isIdentity(transform: Transform): boolean {
  return identity.every((number, i) => transform[i] === number);
}

/** The factor by which the transform changes all lengths; undefined if it differs from direction to direction. */
export function scaleOf(transform: Transform): number | undefined {
  const [a, b, c] = columnsOf(transform);
  const scale = Math.hypot(...a);
  const off = [
    Math.hypot(...b) - scale,
    Math.hypot(...c) - scale,
    ...[dot(a, b), dot(b, c), dot(c, a)].map((product) => product / scale),
  ];
  return off.every((each) => Math.abs(each) < 1e-6 * scale) ? scale : undefined;
}

/** The factor by which the transform changes all volumes. */
export function volumeScaleOf(transform: Transform): number {
  const [a, b, c] = columnsOf(transform);
  return Math.abs(dot(a, cross(b, c)));
}

/** The store with its grid after the transform. The result is a valid grid, because grids may be sheared. */
export function placed(info: StoreInfo, transform: Transform): StoreInfo {
  if (isIdentity(transform)) return info;
  const direction = Array.from<number>({ length: 9 });
  const spacing: Triple = [0, 0, 0];
  for (let axis = 0; axis < 3; ++axis) {
    const edge = turned(transform, edgeOf(info, axis));
    const length = Math.hypot(...edge);
    spacing[axis] = length;
    edge.forEach((number, row) => {
      direction[3 * row + axis] = number / length;
    });
  }
  const moved = turned(transform, info.origin);
  const origin = moved.map((number, row) => number + (transform[4 * row + 3] ?? 0)) as Triple;
  return { ...info, origin, spacing, direction };
}

/** The edge of a cell along an axis of the grid. */
function edgeOf({ direction, spacing }: StoreInfo, axis: number): Triple {
  return [0, 1, 2].map((row) => (direction[3 * row + axis] ?? 0) * (spacing[axis] ?? 0)) as Triple;
}

/**
 * World to clip space for the store of a layer. `viewProjection`: that of the scene, column by column, as
 * the result.
 */
export function viewProjectionOf(viewProjection: Float64Array, transform: Transform): Float64Array {
  if (isIdentity(transform)) return viewProjection;
  return Float64Array.from({ length: 16 }, (_, i) => {
    const [row, column] = [i % 4, Math.floor(i / 4)];
    let sum = 0;
    for (let k = 0; k < 4; ++k) {
      sum += (viewProjection[4 * k + row] ?? 0) * (transform[4 * k + column] ?? 0);
    }
    return sum;
  });
}

/**
 * The share of the picture that the box around a volume covers, 0 … 1. A box that reaches behind the eye
 * covers all of it.
 */
export function coverage(info: StoreInfo, viewProjection: ArrayLike<number>): number {
  const low = [1, 1];
  const high = [-1, -1];
  for (let corner = 0; corner < 8; ++corner) {
    const point: [number, number, number, number] = [...info.origin, 1];
    for (let axis = 0; axis < 3; ++axis) {
      if ((corner >> axis) % 2 === 0) continue;
      const last = (info.voxels[axis] ?? 1) - 1;
      edgeOf(info, axis).forEach((number, row) => {
        point[row] = (point[row] ?? 0) + last * number;
      });
    }
    const clip = (row: number) =>
      point.reduce((sum, number, k) => sum + (viewProjection[4 * k + row] ?? 0) * number, 0);
    const w = clip(3);
    if (!(w > 0)) return 1;
    for (const row of [0, 1]) {
      low[row] = Math.min(low[row] ?? 0, clip(row) / w);
      high[row] = Math.max(high[row] ?? 0, clip(row) / w);
    }
  }
  const extent = (row: number) =>
    Math.max(0, Math.min(1, high[row] ?? 0) - Math.max(-1, low[row] ?? 0)) / 2;
  return extent(0) * extent(1);
}

/** Whether both grids cover the same part of the world with the same voxels. */
export function isSameGrid(a: StoreInfo, b: StoreInfo): boolean {
  const numbers = ({ voxels, spacing, origin, direction }: StoreInfo): number[] => [
    ...voxels,
    ...spacing,
    ...origin,
    ...direction,
  ];
  const other = numbers(b);
  return numbers(a).every((number, i) => number === other[i]);
}
