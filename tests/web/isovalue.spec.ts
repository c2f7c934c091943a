// The texts of the page about isovalues, and the sweep of an isovalue.
import { describe, expect, it, vi } from "vitest";
import { activeCellsAt } from "../../web/core/active_cells.ts";
import { costText } from "../../web/page/panel/isovalue_cost.ts";
import { isovalueScale, roundToScale, sliderEnds } from "../../web/page/panel/isovalue_scale.ts";
import { backAndForth, IsovalueSweep } from "../../web/page/panel/isovalue_sweep.ts";
import type { StoreInfo } from "../../web/stream/index.ts";
import { fakeClock } from "./fake_clock.ts";

describe("the cost of an isovalue", () => {
  const info = {
    metadata: { active_cells: { low: -0.5, high: 3.5, counts: [10, 2000, 300, 4] } },
    mapping: { scale: 1 },
  } as unknown as StoreInfo;

  it("is the number of active cells of the value at or below it", () => {
    expect(
      [0, 0.5, 0.99, 1, 1.5, 2.4, 2.5, 3, 3.5].map((value) => activeCellsAt(info, value)),
    ).toEqual([10, 10, 10, 2000, 2000, 300, 300, 4, 4]);
    expect([-0.5, -0.1, 4, 5].map((value) => activeCellsAt(info, value))).toEqual(
      Array(4).fill(undefined),
    );
    expect(activeCellsAt({ metadata: {}, mapping: { scale: 1 } } as StoreInfo, 1)).toBeUndefined();
  });

  it("is that of the bin, if bins have several values", () => {
    const mapping = { scale: 0.1 };
    const metadata = { active_cells: { low: 0.95, high: 1.55, counts: [7, 8] } };
    const wide = { metadata, mapping } as unknown as StoreInfo;
    const found = [1, 1.1, 1.29, 1.3, 1.31, 1.59].map((value) => activeCellsAt(wide, value));
    expect(found).toEqual([7, 7, 7, 8, 8, 8]);
  });

  it("is stated as far as it is known", () => {
    expect(costText(294_000, 400_000)).toBe("about 294 k active cells, 400 KB at full detail");
    expect(costText(294_000, undefined)).toBe("about 294 k active cells");
    expect(costText(undefined, undefined)).toBe("");
  });
});

describe("the slider", () => {
  it.each([
    [[0, 255], 1, [0, 255]],
    [[1, 4095], 1, [0, 4096]],
    [[-0.51, 0.777], 0.0001, [-0.51, 0.777]],
    [[-1024, 3071], 1, [-1024, 3072]],
  ] as const)("of the range %j begins and ends at multiples of its step", (range, step, ends) => {
    const scale = isovalueScale(range, step);
    expect(sliderEnds(scale)).toEqual(ends);
    // The browser counts steps from the low end, so each step is then an isovalue of the scale.
    const [low] = sliderEnds(scale);
    for (let i = 1; i < 40; ++i) {
      const at = Number((low + i * scale.step).toPrecision(10));
      expect(roundToScale(at, scale)).toBe(at);
    }
  });
});

describe("a sweep", () => {
  fakeClock();

  it("goes back and forth", () => {
    expect([0, 0.25, 1, 1.25, 2, 2.5, -0.25].map(backAndForth)).toEqual([
      0, 0.25, 1, 0.75, 0, 0.5, 0.25,
    ]);
  });

  it("begins with the present value, turns at the ends, and stops", () => {
    const values: number[] = [];
    const sweep = new IsovalueSweep((value) => values.push(value));
    sweep.start(60, 0, 100, 1);
    expect(sweep.isRunning).toBe(true);
    vi.advanceTimersByTime(1000);
    expect(values[0]).toBeCloseTo(60);
    expect(Math.max(...values)).toBeGreaterThan(97);
    expect(Math.max(...values)).toBeLessThanOrEqual(100);
    expect(values.at(-1)).toBeLessThan(60);
    sweep.stop();
    const { length } = values;
    vi.advanceTimersByTime(1000);
    expect(values.length).toBe(length);
    expect(sweep.isRunning).toBe(false);
  });
});
