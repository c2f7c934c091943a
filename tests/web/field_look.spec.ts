import { expect, test } from "vitest";
import type { FieldInfo } from "../../web/core/types.ts";
import { FieldBins } from "../../web/stream/field_bins.ts";
import { shownRange } from "../../web/viewer/field_of.ts";

const field: FieldInfo = {
  name: "pressure",
  mapping: { offset: 100, scale: 0.5, maxError: 0, bits: 16, hasMissing: true },
  quantizedRange: [1000, 1255],
  range: [600, 727.5],
  missingVoxels: 1,
  offset: 0,
  bytes: 0,
};

/** A PackedField with the same value at all corners, for each value. */
const packed = (values: readonly number[]): Uint32Array =>
  Uint32Array.from(values.flatMap((value) => Array(4).fill(value | (value << 16))));

test("the range of a surface leaves out the lowest and highest values of the drawn chunks", () => {
  const bins = new FieldBins(field);
  expect(bins.percentiles([1, 2], 0.01)).toBeUndefined();
  const many = Array.from({ length: 100 }, (_, i) => 1100 + i);
  bins.add(1, packed([1000, ...many, ...many, 1255, 65_535]));
  bins.add(2, packed(many));
  bins.add(3, packed(Array(1000).fill(1002)));
  const [low, high] = bins.percentiles([1, 2], 0.01) ?? [0, 0];
  expect(low).toBeCloseTo(100 + 0.5 * 1100, 0);
  expect(high).toBeCloseTo(100 + 0.5 * 1200, 0);
  // All of them, and those of a chunk that is drawn as well.
  expect(bins.percentiles([1, 2], 0)?.[0]).toBeCloseTo(600, 0);
  expect(bins.percentiles([1, 2, 3], 0.01)?.[0]).toBeCloseTo(601, 0);
  const { low: least, high: most, counts } = bins.histogram([1, 2]);
  expect([least, most, counts.length]).toEqual([600, 727.5, 256]);
  // Eight corners each; missing values are not counted.
  expect(counts.reduce((sum, count) => sum + count, 0)).toBe(8 * 302);
  expect([counts[0], counts[255]]).toEqual([8, 8]);
  bins.remove(3);
  expect(bins.percentiles([3], 0.01)).toBeUndefined();
});

test("the ends of the colours follow the scale, as in the renderer", () => {
  expect(shownRange([-3, 2], "linear")).toEqual([-3, 2]);
  expect(shownRange([-3, 2], "symmetric")).toEqual([-3, 3]);
  expect(shownRange([1, 5], "symmetric")).toEqual([-5, 5]);
  expect(shownRange([2, 2000], "logarithmic")).toEqual([2, 2000]);
  expect(shownRange([0, 2000], "logarithmic")).toEqual([2, 2000]);
  expect(shownRange([-5, -1], "logarithmic")).toEqual([0.001, 1]);
});
