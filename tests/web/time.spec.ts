/**
 * Scenes with time: the order of steps, the steps that are fetched in advance, and the cost of
 * playing.
 */
import { describe, expect, test } from "vitest";
import { Bandwidth } from "../../web/viewer/bandwidth.ts";
import { activeCells, costOfLayers, fieldShare, playCost } from "../../web/viewer/time_cost.ts";
import {
  nearestStep,
  nextPosition,
  type PlayMode,
  type PlayPosition,
  stepsAhead,
} from "../../web/viewer/time_order.ts";
import {
  cellPixelsThatPlay,
  completeCosts,
  planAhead,
  stepsThatFit,
} from "../../web/viewer/time_plan.ts";

describe("the order of steps", () => {
  const played = (from: PlayPosition, count: number, mode: PlayMode, most: number) => {
    const steps: number[] = [];
    let position: PlayPosition | null = from;
    while (position && steps.length < most) {
      steps.push(position.step);
      position = nextPosition(position, count, mode);
    }
    return steps;
  };

  test("loops, in both directions", () => {
    expect(played({ step: 1, direction: 1 }, 3, "loop", 6)).toEqual([1, 2, 0, 1, 2, 0]);
    expect(played({ step: 1, direction: -1 }, 3, "loop", 5)).toEqual([1, 0, 2, 1, 0]);
  });

  test("swings, showing the ends once", () => {
    expect(played({ step: 1, direction: 1 }, 3, "swing", 7)).toEqual([1, 2, 1, 0, 1, 2, 1]);
    expect(played({ step: 0, direction: 1 }, 2, "swing", 4)).toEqual([0, 1, 0, 1]);
  });

  test("ends", () => {
    expect(played({ step: 1, direction: 1 }, 4, "once", 9)).toEqual([1, 2, 3]);
    expect(played({ step: 1, direction: -1 }, 4, "once", 9)).toEqual([1, 0]);
    expect(played({ step: 0, direction: 1 }, 1, "loop", 9)).toEqual([0]);
  });

  test("looks ahead at all other steps, each once, the next one first", () => {
    expect(stepsAhead({ step: 1, direction: 1 }, 4, "loop")).toEqual([2, 3, 0]);
    expect(stepsAhead({ step: 2, direction: 1 }, 4, "swing")).toEqual([3, 1, 0]);
    expect(stepsAhead({ step: 2, direction: 1 }, 5, "once")).toEqual([3, 4, 1, 0]);
    expect(stepsAhead({ step: 2, direction: -1 }, 5, "once")).toEqual([1, 0, 3, 4]);
    expect(stepsAhead({ step: 0, direction: 1 }, 1, "loop")).toEqual([]);
    for (const mode of ["loop", "swing", "once"] as const) {
      for (let step = 0; step < 9; ++step) {
        const ahead = stepsAhead({ step, direction: step % 2 ? 1 : -1 }, 9, mode);
        expect([step, ...ahead].sort()).toEqual([0, 1, 2, 3, 4, 5, 6, 7, 8]);
      }
    }
  });

  test("a value names the nearest step", () => {
    expect([-5, 0.4, 0.6, 99].map((value) => nearestStep([0, 1, 10], value))).toEqual([0, 0, 1, 2]);
  });
});

describe("the detail that plays", () => {
  const costs = [
    { level: 0, bytes: 400_000, cells: 80_000 },
    { level: 1, bytes: 100_000, cells: 20_000 },
    { level: 2, bytes: 25_000, cells: 5_000 },
  ];

  const bytesAt = (pixels: number) =>
    costs.find(({ level }) => level === Math.log2(pixels))?.bytes ?? 0;

  test("is the finest that arrives in time", () => {
    expect(cellPixelsThatPlay(bytesAt, 10, undefined)).toBe(1);
    expect(cellPixelsThatPlay(bytesAt, 10, 10e6)).toBe(1);
    expect(cellPixelsThatPlay(bytesAt, 10, 1e6)).toBe(2);
    expect(cellPixelsThatPlay(bytesAt, 4, 1e6)).toBe(1);
    expect(cellPixelsThatPlay(bytesAt, 10, 200_000)).toBe(4);
  });

  test("is coarser if the finest was too slow", () => {
    expect(cellPixelsThatPlay(bytesAt, 4, 1e6, true)).toBe(2);
    expect(cellPixelsThatPlay(bytesAt, 2, 1e6, true)).toBe(1);
  });

  test("is a coarse level, which is resident in any case, if nothing else arrives in time", () => {
    expect(cellPixelsThatPlay(bytesAt, 10, 1000)).toBe(8);
    expect(cellPixelsThatPlay(() => 1e6, 10, 1000)).toBe(64);
  });

  test("is estimated where a directory has not been fetched", () => {
    expect(completeCosts(costs, 3, 5)).toEqual(costs);
    const [, one, two] = costs;
    if (!one || !two) throw new Error("no costs");
    expect(completeCosts([one, two], 2, undefined)).toEqual([
      { level: 0, bytes: 400_000, cells: 80_000 },
      one,
    ]);
    expect(completeCosts([two], 2, 80_000)).toEqual([costs[0], one]);
    expect(completeCosts([], 1, 100)).toEqual([{ level: 0, bytes: 250, cells: 100 }]);
    expect(completeCosts([], 1, undefined)).toEqual([]);
  });
});

describe("steps in advance", () => {
  const plan = (change: Partial<Parameters<typeof planAhead>[0]> = {}) =>
    planAhead({
      ahead: [1, 2, 3, 4, 5, 6, 7, 8],
      most: 8,
      byteBudget: 500,
      stepBytes: 100,
      isReady: () => false,
      isPlaying: true,
      ...change,
    });

  test("as many fit into memory as their samples allow, but at least two", () => {
    expect(stepsThatFit(1400, 100, 50)).toBe(10);
    expect(stepsThatFit(1400, 100, 3)).toBe(3);
    expect(stepsThatFit(100, 100, 50)).toBe(2);
    expect(stepsThatFit(100, 100, 1)).toBe(1);
    expect(stepsThatFit(100, 0, 50)).toBe(50);
  });

  test("are limited by bytes while playing, and few at rest", () => {
    expect(plan()).toEqual({ kept: [1, 2, 3, 4, 5], refined: [1, 2, 3] });
    expect(plan({ stepBytes: 1000 })).toEqual({ kept: [1, 2], refined: [1, 2] });
    expect(plan({ isPlaying: false })).toEqual({ kept: [1, 2], refined: [1] });
  });

  test("stay when they are ready, as long as they fit", () => {
    const isReady = (step: number) => step < 4 || step === 8;
    expect(plan({ isReady })).toEqual({ kept: [1, 2, 3, 4, 5, 8], refined: [4, 5] });
    expect(plan({ isReady, most: 5 })).toEqual({ kept: [1, 2, 3, 4, 5], refined: [4, 5] });
    expect(plan({ isReady, isPlaying: false })).toEqual({ kept: [1, 2, 3, 8], refined: [] });
    expect(plan({ isReady: () => true, most: 3 })).toEqual({ kept: [1, 2, 3], refined: [] });
  });
});

describe("bandwidth", () => {
  test("is measured while something is fetched", () => {
    const bandwidth = new Bandwidth();
    expect(bandwidth.bytesPerSecond).toBeUndefined();
    bandwidth.add(0, 0, true);
    bandwidth.add(100, 250_000, true);
    expect(bandwidth.bytesPerSecond).toBeUndefined();
    bandwidth.add(400, 1_000_000, true);
    expect(bandwidth.bytesPerSecond).toBe(2.5e6);
  });

  test("does not count pauses", () => {
    const bandwidth = new Bandwidth();
    bandwidth.add(0, 0, true);
    bandwidth.add(200, 500_000, false);
    bandwidth.add(9000, 500_000, false);
    bandwidth.add(9000, 500_000, true);
    bandwidth.add(9200, 1_000_000, false);
    expect(bandwidth.bytesPerSecond).toBeCloseTo(2.5e6);
  });

  test("does not count few bytes, which measure the round trip", () => {
    const bandwidth = new Bandwidth();
    for (let i = 0; i < 20; ++i) {
      bandwidth.add(500 * i, 20_000 * i, true);
      bandwidth.add(500 * i + 300, 20_000 * (i + 1), false);
    }
    expect(bandwidth.bytesPerSecond).toBeUndefined();
    bandwidth.add(20_000, 500_000, true);
    for (let i = 1; i <= 10; ++i) bandwidth.add(20_000 + 200 * i, 500_000 + 20_000 * i, true);
    expect(bandwidth.bytesPerSecond).toBeCloseTo(100_000);
  });

  test("follows changes", () => {
    const bandwidth = new Bandwidth();
    for (let i = 0; i <= 20; ++i) bandwidth.add(200 * i, 500_000 * i, true);
    for (let i = 1; i <= 40; ++i) bandwidth.add(4000 + 200 * i, 10e6 + 50_000 * i, true);
    expect(bandwidth.bytesPerSecond).toBeGreaterThan(200_000);
    expect(bandwidth.bytesPerSecond).toBeLessThan(400_000);
  });
});

describe("the cost of playing", () => {
  const step = (bytes?: number, cells?: number) => ({ bytes, cells });

  test("is exact if all steps are known", () => {
    expect(playCost([step(100), step(200)])).toEqual({ steps: 2, bytes: 300, isEstimated: false });
  });

  test("follows from the cells that headers state, or from other steps", () => {
    const cost = { steps: 3, isEstimated: true };
    expect(playCost([step(100, 50), step(undefined, 150), step()])).toEqual({
      ...cost,
      bytes: 600,
    });
    expect(playCost([step(100), step(), step()])).toEqual({ ...cost, bytes: 300 });
    expect(playCost([step(undefined, 5), step()])).toBeUndefined();
  });

  test("includes the bytes of the field that is shown, which are estimated", () => {
    const info = { fileBytes: 5500, fields: [{ bytes: 1500 }, { bytes: 1000 }] };
    expect(fieldShare(info, { bytes: 1500 })).toBe(0.5);
    expect(fieldShare(info, undefined)).toBe(0);
    expect(fieldShare({ fileBytes: 3000, fields: [] }, undefined)).toBe(0);
    const shown = { ...step(150), isEstimated: true };
    expect(playCost([shown, shown])).toEqual({ steps: 2, bytes: 300, isEstimated: true });
  });

  test("of layers is their sum", () => {
    const a = { steps: 2, bytes: 100, isEstimated: false };
    expect(costOfLayers([a, { ...a, bytes: 5, isEstimated: true }])).toEqual({
      steps: 2,
      bytes: 105,
      isEstimated: true,
    });
    expect(costOfLayers([a, undefined])).toBeUndefined();
    expect(costOfLayers([])).toBeUndefined();
  });

  test("the header states the cells of an isovalue", () => {
    const counts = Array.from({ length: 256 }, (_, i) => (i < 255 ? 1000 - i : 0));
    const metadata = { active_cells: { low: -0.5, high: 255.5, counts } };
    const mapping = { scale: 1 };
    const cells = (value: number) => activeCells({ metadata, mapping }, value);
    // A cell is active up to its largest voxel: between 254 and 255 are the cells of 254.
    expect([0, 0.9, 1, 254, 254.5, 254.9].map(cells)).toEqual([1000, 1000, 999, 746, 746, 746]);
    expect([-1, 255, 256, 1000].map(cells)).toEqual([0, 0, 0, 0]);
    expect(activeCells({ metadata: {}, mapping }, 1)).toBeUndefined();
  });
});
