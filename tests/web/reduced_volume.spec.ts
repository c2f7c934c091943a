// The reduced copy of a volume: the positions and values of its voxels.
import { expect, it } from "vitest";
import type { VolumeDescription } from "../../web/builder/types.ts";
import { reducedVolume } from "../../web/import/reduced_volume.ts";

const volume: VolumeDescription = {
  voxels: [129, 3, 300],
  type: "i16",
  spacing: [0.5, 2, 1],
  origin: [7, 8, 9],
  name: "head",
  format: "raw",
};

it("has the voxels nearest to evenly spaced positions, including the first and the last", () => {
  const read: number[] = [];
  const { description, voxels } = reducedVolume(volume, (z) => {
    read.push(z);
    const slice = Int16Array.from({ length: 129 * 3 }, (_, i) => 100 * z + (i % 129) - 5);
    return new Uint8Array(slice.buffer);
  });
  expect(description).toMatchObject({ voxels: [65, 3, 65], origin: [7, 8, 9], type: "i16" });
  const extent = description.spacing?.map(
    (each, axis) => each * ((description.voxels[axis] ?? 0) - 1),
  );
  expect(extent?.map((each) => Number(each.toFixed(9)))).toEqual([64, 4, 299]);
  expect(read.length).toBe(65);
  expect(read.slice(0, 3)).toEqual([0, 5, 9]);
  expect(read.at(-1)).toBe(299);
  const values = new Int16Array(voxels.buffer);
  expect(values.length).toBe(65 * 3 * 65);
  expect([...values.slice(0, 3)]).toEqual([-5, -3, -1]);
  expect(values.at(-1)).toBe(29900 + 128 - 5);
});
