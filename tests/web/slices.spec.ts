// The planes of slices in grids of any axes.
import { expect, it } from "vitest";
import type { StoreInfo } from "../../web/core/types.ts";
import { hasSlices, noSlices, slicePlanes, usableSlices } from "../../web/viewer/slices.ts";
import type { Slices } from "../../web/viewer/types.ts";

// A mirrored, sheared and turned grid: columns are the axes, and not perpendicular.
const info = {
  voxels: [11, 21, 31],
  spacing: [2, 0.5, 1.5],
  origin: [100, -40, 7],
  direction: [-0.8, 0.6, 0, 0.6, 0.8, 0.28, 0, 0, 0.96],
} as unknown as StoreInfo;

function world(index: readonly number[]): number[] {
  const { direction, origin, spacing } = info;
  return [0, 1, 2].map((row) =>
    index.reduce(
      (sum, n, axis) => sum + (direction[3 * row + axis] ?? 0) * (spacing[axis] ?? 0) * n,
      origin[row] ?? 0,
    ),
  );
}

it.each([0, 1, 2])("are perpendicular to axis %i at the requested voxel", (axis) => {
  for (const share of [0, 0.3, 1]) {
    const along = [0, 1, 2].map((other) => (other === axis ? share : null));
    const slices = { along } as unknown as Slices;
    expect(hasSlices(slices)).toBe(true);
    const [plane, ...more] = slicePlanes(slices, info);
    expect(more).toEqual([]);
    const at = (index: readonly number[]) => {
      const place = world(index);
      const size = Math.hypot(...(plane?.normal ?? []));
      const height = (plane?.normal ?? []).reduce((sum, n, i) => sum + n * (place[i] ?? 0), 0);
      return (height - (plane?.offset ?? 0)) / size;
    };
    for (const others of [
      [0, 0],
      [5, 3],
      [-2, 17.5],
    ]) {
      const index = [...others];
      index.splice(axis, 0, share * ((info.voxels[axis] ?? 0) - 1));
      expect(at(index)).toBeCloseTo(0, 9);
      index[axis] = (index[axis] ?? 0) + 1;
      expect(Math.abs(at(index))).toBeGreaterThan(0.1);
    }
  }
});

it("are one for each position and plane", () => {
  expect(hasSlices(noSlices)).toBe(false);
  expect(slicePlanes(noSlices, info)).toEqual([]);
  const plane = { normal: [0, 0.6, 0.8] as [number, number, number], offset: 3 };
  expect(slicePlanes({ along: [null, 0, 1], plane }, info)).toHaveLength(3);
  expect(slicePlanes({ along: [null, null, null], plane }, info)).toEqual([plane]);
});

it("are made valid, whatever a script sets", () => {
  const plane = { normal: [0, 0, 2], offset: 1 } as const;
  const set = (slices: unknown) => usableSlices(slices as Slices);
  for (const nothing of [{}, { along: [] }, { along: [Number.NaN, undefined, "x"] }]) {
    expect(set(nothing)).toEqual(noSlices);
  }
  expect(set({ along: [-1, 0.5, 7] })).toEqual({ along: [0, 0.5, 1] });
  expect(set({ plane })).toEqual({ along: [null, null, null], plane });
  for (const other of [
    { normal: [0, 0, 0], offset: 1 },
    { normal: [0, Number.NaN, 1], offset: 1 },
    { normal: [0, 1], offset: 1 },
    { normal: [0, 0, 1] },
    {},
  ]) {
    expect(hasSlices(set({ plane: other }))).toBe(false);
  }
  expect(set({ range: [1, 2] }).range).toEqual([1, 2]);
  for (const range of [[2, 1], [1], [Number.NaN, 1], [0, Number.POSITIVE_INFINITY]]) {
    expect(set({ range }).range).toBeUndefined();
  }
});
