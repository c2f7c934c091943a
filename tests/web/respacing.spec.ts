// What lies in the world of a volume moves along with its voxels when their distances change.
import { expect, test } from "vitest";
import type { Triple } from "../../web/core/types.ts";
import { type Measurement, voxelOf } from "../../web/measure/measurement.ts";
import { movedMeasurement } from "../../web/measure/moved_measurement.ts";
import { respacing } from "../../web/viewer/respacing.ts";
import type { Camera } from "../../web/viewer/types.ts";

/** Axes of unit length that are neither those of the world nor perpendicular: columns. */
const sheared = {
  origin: [3, -2, 7] as Triple,
  spacing: [1, 1, 1] as Triple,
  direction: [0.6, 0, 0, 0.8, 0, 0.6, 0, 1, 0.8],
};
const straight = { ...sheared, direction: [1, 0, 0, 0, 1, 0, 0, 0, 1] };
const after: Triple = [0.5, 2, 1.25];
const points: Triple[] = [
  [3, -2, 7],
  [10, 4, -1],
  [0.5, 0.25, 100],
];

test.each([
  ["perpendicular", straight],
  ["sheared", sheared],
])("a point keeps its voxel coordinates in a grid with %s axes", (_, grid) => {
  const { point } = respacing(grid, after);
  for (const position of points) {
    const moved = voxelOf({ ...grid, spacing: after }, point(position));
    voxelOf(grid, position).forEach((index, axis) => {
      expect(moved[axis]).toBeCloseTo(index, 10);
    });
  }
  expect(point(grid.origin)).toEqual(grid.origin);
});

test.each([
  ["perpendicular", straight],
  ["sheared", sheared],
])("a plane keeps the points on its sides in a grid with %s axes", (_, grid) => {
  const change = respacing(grid, after);
  const normal: Triple = [2, -1, 0.5];
  const distance = (position: Triple, plane: { normal: Triple; offset: number }) =>
    plane.normal.reduce((sum, n, axis) => sum + n * (position[axis] ?? 0), -plane.offset);
  for (const through of points) {
    const plane = { normal, offset: distance(through, { normal, offset: 0 }) };
    const moved = change.plane(plane);
    expect(Math.hypot(...moved.normal)).toBeCloseTo(1, 12);
    expect(distance(change.point(through), moved)).toBeCloseTo(0, 10);
    for (const position of points) {
      const before = distance(position, plane);
      if (Math.abs(before) < 1e-9) continue;
      expect(Math.sign(distance(change.point(position), moved))).toBe(Math.sign(before));
    }
  }
});

test("the camera looks at the same voxel, from a distance that grows with the volume", () => {
  const camera: Camera = {
    target: [10, 4, -1],
    distance: 80,
    azimuth: 30,
    elevation: 20,
    roll: 5,
    fieldOfView: 30,
  };
  const uniform = respacing(straight, [0.25, 0.25, 0.25]).camera(camera);
  expect(uniform).toEqual({ ...camera, target: [4.75, -0.5, 5], distance: 20 });
  expect(respacing(straight, [1, 2, 4]).camera(camera).distance).toBeCloseTo(160, 10);
});

test("a measurement keeps its values; its normals stay perpendicular to the surface", () => {
  const length = Math.hypot(1, 1);
  const measurement: Measurement = {
    kind: "point",
    points: [
      {
        position: [10, 4, -1],
        value: 60.5,
        normal: [1 / length, 1 / length, 0],
        level: 2,
        voxel: [7, 6, -8],
      },
      { position: [0, 0, 0] },
    ],
    text: "a",
  };
  const change = respacing(straight, [1, 3, 1]);
  const [point, bare] = movedMeasurement(measurement, change).points;
  expect(point).toMatchObject({ position: [10, 16, -1], value: 60.5, level: 2, voxel: [7, 6, -8] });
  const [x = 0, y = 0, z] = point?.normal ?? [];
  // The tangent (1, −1, 0) has become (1, −3, 0).
  expect(x - 3 * y).toBeCloseTo(0, 12);
  expect(Math.hypot(x, y)).toBeCloseTo(1, 12);
  expect(z).toBe(0);
  expect(bare).toEqual({ position: [0, 4, 0] });
});
