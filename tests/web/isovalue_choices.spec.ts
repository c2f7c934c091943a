/** The isovalues that the panel offers, and their names. */
import { describe, expect, test } from "vitest";
import type { StoreInfo, StoreMetadata } from "../../web/core/types.ts";
import { isovalueChoices } from "../../web/page/panel/isovalue_choices.ts";

const info = (metadata: StoreMetadata) => ({ metadata, mapping: { scale: 1 } }) as StoreInfo;
const cells = (low: number, high: number, count = 1) => ({
  low,
  high,
  counts: Array.from({ length: 100 }, () => count),
});

describe("offered isovalues", () => {
  test("are the first four suggestions, without names", () => {
    const suggested_isovalues = [-300, 300, 3, 4, 5];
    const active_cells = cells(-1000, 1000);
    for (const units of [undefined, "mm", "hu"]) {
      const metadata = { suggested_isovalues, active_cells, ...(units ? { units } : {}) };
      expect(isovalueChoices(info(metadata))).toEqual(
        [-300, 300, 3, 4].map((isovalue) => ({ isovalue })),
      );
    }
    expect(isovalueChoices(info({}))).toEqual([]);
  });

  test("in Hounsfield units have the names of tissues", () => {
    const metadata = { units: "HU", active_cells: cells(-1024, 3000) };
    expect(isovalueChoices(info({ ...metadata, suggested_isovalues: [-309, 180, 30] }))).toEqual([
      { isovalue: -309, tissue: "skin" },
      { isovalue: 180, tissue: "bone" },
      { isovalue: 30 },
    ]);
  });

  test("in Hounsfield units include tissues that no suggestion shows, if they have a surface", () => {
    const offered = (suggested_isovalues: number[], active_cells = cells(-1024, 3000)) =>
      isovalueChoices(info({ units: "HU", suggested_isovalues, active_cells }));
    const skin = { isovalue: -300, tissue: "skin" };
    const bone = { isovalue: 250, tissue: "bone" };
    expect(offered([-600, 30])).toEqual([{ isovalue: -600 }, { isovalue: 30 }, skin, bone]);
    // Suggestions give way, since there is room for four.
    expect(offered([300, -600, -500, 30])).toEqual([
      { isovalue: 300, tissue: "bone" },
      { isovalue: -600 },
      { isovalue: -500 },
      skin,
    ]);
    expect(offered([30], cells(-200, 200))).toEqual([{ isovalue: 30 }]);
    expect(offered([30], cells(-1024, 3000, 0))).toEqual([{ isovalue: 30 }]);
    expect(isovalueChoices(info({ units: "HU" }))).toEqual([]);
  });

  test("of density maps are stated in standard deviations from the mean", () => {
    // Half of the voxels have −1.5, half of them 3.5: mean 1, standard deviation 2.5.
    const histogram = { low: -2, high: 4, counts: [1, 0, 0, 0, 0, 1].map((n) => n * 50) };
    const suggested_isovalues = [9];
    const [choice] = isovalueChoices(
      info({ source: { format: "MRC" }, histogram, suggested_isovalues }),
    );
    expect(choice?.deviations).toBeCloseTo((9 - 1) / 2.5);
    const other = { source: { format: "NRRD" }, histogram, suggested_isovalues };
    expect(isovalueChoices(info(other))).toEqual([{ isovalue: 9 }]);
    const constant = { source: { format: "MRC" }, histogram: { low: 0, high: 1, counts: [0] } };
    expect(isovalueChoices(info({ ...constant, suggested_isovalues }))).toEqual([{ isovalue: 9 }]);
  });
});
