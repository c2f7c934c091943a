// The distance of contour lines that the page proposes, and their ticks in the legend.
import { expect, test } from "vitest";
import { fittingInterval, hasLines, lineTicks } from "../../web/viewer/field_lines.ts";
import { usableField } from "../../web/viewer/field_of.ts";
import { defaultLook } from "../../web/viewer/types.ts";

const greys = Array.from({ length: 256 }, (_, i) => `rgb(${i} ${i} ${i})`);

test("the proposed interval gives about ten lines, at round values", () => {
  expect(fittingInterval([0, 100], "linear")).toBe(10);
  expect(fittingInterval([101_300, 101_330], "linear")).toBe(2);
  expect(fittingInterval([-0.25, 0.25], "symmetric")).toBe(0.05);
  expect(fittingInterval([1, 1000], "logarithmic")).toBe(0.2);
  expect(fittingInterval([1e-12, 1e8], "logarithmic")).toBe(2);
  for (let length = 1e-9; length < 1e9; length *= 1.37) {
    const lines = length / fittingInterval([3, 3 + length], "linear");
    expect(lines).toBeGreaterThan(6);
    expect(lines).toBeLessThan(17);
  }
});

test("a range that is none has an interval all the same", () => {
  const ranges: [number, number][] = [
    [1, 1],
    [2, 1],
    [Number.NaN, 1],
    [-1e308, 1e308],
    [0, 5e-324],
    [0, Number.POSITIVE_INFINITY],
  ];
  for (const range of ranges) expect(fittingInterval(range, "linear")).toBe(1);
  expect(fittingInterval([0, 1], "logarithmic")).toBe(1);
});

test("ticks are at the multiples of the interval", () => {
  expect(lineTicks([-5, 25], "linear", 10, greys).map(({ at }) => at)).toEqual([1 / 6, 0.5, 5 / 6]);
  const [first, ...others] = lineTicks([0.1, 0.3], "linear", 0.1, greys);
  expect(first?.at).toBeCloseTo(0);
  expect(others.map(({ at }) => at)).toEqual([expect.closeTo(0.5), expect.closeTo(1)]);
  const decades = lineTicks([2, 2000], "logarithmic", 1, greys);
  expect(decades.map(({ at }) => 2 * 1000 ** at)).toEqual(
    [10, 100, 1000].map((v) => expect.closeTo(v)),
  );
});

test("ticks are dark on bright colours, as lines are", () => {
  const ticks = lineTicks([0, 1], "linear", 0.25, greys);
  expect(ticks.map(({ isDark }) => isDark)).toEqual([false, false, true, true, true]);
});

test("a legend has no more ticks than it can show", () => {
  expect(lineTicks([0, 1], "linear", 0.01, greys)).toEqual([]);
  for (const interval of [1e-300, 0, -1, Number.NaN, Number.POSITIVE_INFINITY]) {
    expect(lineTicks([0.5, 1], "linear", interval, greys)).toEqual([]);
  }
  expect(lineTicks([1, 1], "linear", 1, greys)).toEqual([]);
  expect(lineTicks([0, 10], "logarithmic", 1, greys)).toEqual([]);
});

test("with colour steps, ticks contrast with the colour of their step, on a border with the higher one", () => {
  const black = "rgb(0 0 0)";
  const white = "rgb(255 255 255)";
  const dark = (range: [number, number], colours: string[]) =>
    lineTicks(range, "linear", 1, colours, colours.length).map(({ isDark }) => isDark);
  // At 0.1, 0.3 … 0.9 of the colours, whose middle is grey.
  expect(dark([0.5, 5.5], [black, white])).toEqual([false, false, true, true, true]);
  expect(dark([0.5, 5.5], [white, black, white])).toEqual([true, true, false, true, true]);
  expect(dark([0, 3], [black, white, black])).toEqual([false, true, false, false]);
  for (let steps = 2; steps <= 12; steps++) {
    const colours = Array.from({ length: steps }, (_, i) => (i % 2 ? white : black));
    const expected = colours.map((colour) => colour === white);
    expect(dark([0.3, steps + 0.3], colours)).toEqual(expected);
    expect(dark([0.1, steps + 0.1], colours)).toEqual(expected);
    expect(dark([0, steps], colours)).toEqual([...expected, expected.at(-1)]);
  }
});

test("there are no lines at distances at which the renderer draws none", () => {
  expect(hasLines(0.0625, "linear", 1)).toBe(true);
  expect(hasLines(0.0624, "symmetric", 1)).toBe(false);
  expect(hasLines(1e-4, "logarithmic", 1)).toBe(true);
  expect(hasLines(0.99e-4, "logarithmic", 1)).toBe(false);
  expect(hasLines(1e9, "linear", 0.01)).toBe(true);
  for (const scale of ["linear", "logarithmic", "symmetric"] as const) {
    for (const none of [0, -1, Number.NaN, Number.POSITIVE_INFINITY, 1e-300, 1e300]) {
      expect(hasLines(none, scale, 0.01)).toBe(false);
    }
  }
  expect(hasLines(1, "linear", 0)).toBe(false);
});

test("a look has a finite distance of lines", () => {
  const usable = (lines: number) => usableField({ ...defaultLook.field, lines }).lines;
  const none = [0, -1, Number.NaN, Number.POSITIVE_INFINITY, Number.NEGATIVE_INFINITY];
  expect(none.map(usable)).toEqual([0, 0, 0, 0, 0]);
  expect(usable(0.5)).toBe(0.5);
});
