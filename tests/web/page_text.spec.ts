import { describe, expect, it } from "vitest";
import { isovalueScale, roundToScale } from "../../web/page/panel/isovalue_scale.ts";
import { withAddedSurface } from "../../web/page/panel/surfaces.ts";
import {
  formatAxes,
  formatBytes,
  formatCount,
  formatValue,
  parseValue,
} from "../../web/page/shell/format.ts";
import { levelText, stateText } from "../../web/page/volume/status_text.ts";
import type { Progress } from "../../web/stream/types.ts";
import { surfacesAt } from "../../web/viewer/surfaces.ts";
import { completeText } from "../support/complete_text.ts";

describe("numbers for people", () => {
  it("has three digits and a unit", () => {
    expect([0, 999, 1000, 12_345, 999_499, 999_500, 1.2345e9].map(formatCount)).toEqual([
      "0",
      "999",
      "1.00 k",
      "12.3 k",
      "999 k",
      "1.00 M",
      "1.23 G",
    ]);
    expect([0, 523_000, 6.0e6].map(formatBytes)).toEqual(["0 B", "523 KB", "6.00 MB"]);
  });

  it("writes isovalues without noise", () => {
    expect([60.5, 0.1 + 0.2, -1024, 1e-7, Number.NaN].map(formatValue)).toEqual([
      "60.5",
      "0.3",
      "-1024",
      "1e-7",
      "–",
    ]);
  });
});

describe("numbers that people type", () => {
  it("takes a decimal comma as a decimal point, whatever the language", () => {
    const typed = [
      "12,5",
      "12.5",
      " 60,5 ",
      "-1024",
      "\u2212500",
      "+3",
      ",5",
      "7.",
      "1e-7",
      "1,5e3",
    ];
    expect(typed.map(parseValue)).toEqual([12.5, 12.5, 60.5, -1024, -500, 3, 0.5, 7, 1e-7, 1500]);
  });

  it("accepts groups of digits if they are unambiguous", () => {
    const typed = [
      "1.024,5",
      "1,024.5",
      "1 024,5",
      "1\u202f024",
      "1,234,567",
      "1.234.567",
      "12'000",
    ];
    expect(typed.map(parseValue)).toEqual([1024.5, 1024.5, 1024.5, 1024, 1234567, 1234567, 12000]);
  });

  it("accepts nothing else", () => {
    const typed = [
      "",
      " ",
      "abc",
      "12abc",
      "1,2,3",
      "1.2.3",
      "1,23.4,5",
      "--1",
      ".",
      "e5",
      "1e999",
      "NaN",
    ];
    for (const text of typed) expect(parseValue(text), text).toBeUndefined();
  });
});

describe("a surface that is added", () => {
  const scale = isovalueScale([0, 255], 1);
  const added = (count: number, suggestions: readonly number[], at = scale) => {
    let surfaces = surfacesAt([suggestions[0] ?? at.low]);
    for (let i = 1; i < count; ++i) surfaces = withAddedSurface(surfaces, suggestions, at);
    return surfaces.map((surface) => surface.isovalue);
  };

  it("never has the isovalue of another", () => {
    for (const suggestions of [[60.5, 100.5, 180.5], [60.5], [], [0, 255]]) {
      const isovalues = added(8, suggestions);
      expect(new Set(isovalues).size, String(isovalues)).toBe(8);
      for (const value of isovalues) expect(value >= 0 && value <= 255).toBe(true);
    }
    const narrow = added(8, [], isovalueScale([0, 1], 1));
    expect(new Set(narrow).size, String(narrow)).toBe(8);
  });

  it("has a suggested isovalue as long as one is free", () => {
    expect(added(3, [60.5, 100.5, 180.5])).toEqual([60.5, 180.5, 100.5]);
  });
});

describe("axes", () => {
  it("are named where they are not perpendicular", () => {
    expect(formatAxes([1, 0, 0, 0, 1, 0, 0, 0, 1])).toBeUndefined();
    expect(formatAxes([0.6, -0.8, 0, 0.8, 0.6, 0, 0, 0, 1])).toBeUndefined();
    // 18.5° of gantry tilt: the second axis leads up as well.
    expect(formatAxes([1, 0, 0, 0, Math.cos(0.3229), 0, 0, Math.sin(0.3229), 1])).toBe(
      "not perpendicular: 18.5° off",
    );
  });
});

describe("the isovalue scale", () => {
  it("steps by halves through 8 bit", () => {
    const scale = isovalueScale([0, 255], 1);
    expect(scale).toEqual({ low: 0, high: 255, step: 0.5 });
    expect(roundToScale(60.4, scale)).toBe(60.5);
    expect(roundToScale(-3, scale)).toBe(0);
    expect(roundToScale(300, scale)).toBe(255);
  });

  it("steps by round numbers through anything else", () => {
    expect(isovalueScale([-1024, 3071], 1).step).toBe(2);
    expect(isovalueScale([0, 1], 1 / 65534).step).toBe(0.0005);
    const steps = [0.0037, 0.1, 7, 250].map((step) => isovalueScale([0, 2000 * step], 0.1).step);
    expect(steps).toEqual([0.002, 0.1, 5, 200]);
  });

  it("stays within a range that is not a multiple of the step", () => {
    const scale = isovalueScale([-0.51, 0.777], 2e-5);
    expect(roundToScale(1, scale)).toBe(0.777);
    expect(roundToScale(-1, scale)).toBe(-0.51);
  });

  it("is valid for a volume of one value", () => {
    const scale = isovalueScale([5, 5], 1);
    expect(scale.high).toBeGreaterThan(scale.low);
    expect(roundToScale(5, scale)).toBe(5);
  });
});

describe("the status line", () => {
  const progress: Progress = {
    state: "refining",
    chunksToGo: 3,
    bytesToGo: 120_000,
    bytesFetched: 5,
    requests: 1,
    chunksResident: 0,
    samplesResident: 0,
    sampleBudget: 1e6,
    finestLevel: 0,
    coarsestLevel: 2,
    limitedByBudget: false,
    complete: false,
    preparation: null,
    damagedParts: 0,
    fault: null,
  };

  it("states the data still to fetch, and when the view is complete", () => {
    expect(stateText(progress)).toBe("120 KB to go");
    expect(stateText({ ...progress, state: "complete" })).toBe("complete");
    expect(stateText({ ...progress, state: "complete" }, true)).toBe(
      "complete: a part is clipped away",
    );
    expect(stateText({ ...progress, state: "complete", finestLevel: -1 }, true)).toBe(
      "complete: no surface in this view, where a part is clipped away",
    );
    const preparation = { bytes: 1_200_000, bytesPlanned: 4_000_000 };
    const preparing = stateText({ ...progress, state: "complete", preparation });
    expect(preparing).toBe("complete · preparing other isovalues, 1.20 MB of 4.00 MB");
    // Tests wait for the end of all requests by this text.
    expect(preparing).not.toMatch(completeText);
    expect(stateText({ ...progress, state: "offline" })).toContain("trying again");
  });

  it("states what is missing if no more data will arrive", () => {
    const fault = { kind: "damaged-part", message: "" } as const;
    const damaged: Progress = { ...progress, state: "incomplete", fault, damagedParts: 3 };
    expect(stateText(damaged)).toBe("complete except for 3 damaged parts");
    expect(stateText({ ...damaged, damagedParts: 1 })).toBe("complete except for 1 damaged part");
    const gone: Progress = { ...damaged, fault: { kind: "not-found", message: "" } };
    expect(stateText(gone)).toBe("parts are missing");
  });

  it("is matched by the browser tests' pattern only if nothing is missing", () => {
    const complete: Progress = { ...progress, state: "complete" };
    expect(stateText(complete)).toMatch(completeText);
    expect(stateText({ ...complete, finestLevel: -1 })).toMatch(completeText);
    const fault = { kind: "damaged-part", message: "" } as const;
    const damaged: Progress = { ...progress, state: "incomplete", fault, damagedParts: 1 };
    for (const other of [damaged, progress, { ...progress, state: "limited" } as Progress]) {
      expect(stateText(other)).not.toMatch(completeText);
    }
  });

  it("states the levels that are shown", () => {
    expect(levelText(progress)).toBe("levels 0–2");
    expect(levelText({ ...progress, coarsestLevel: 0 })).toBe("full resolution");
    expect(levelText({ ...progress, finestLevel: 2 })).toBe("level 2");
    expect(levelText({ ...progress, finestLevel: -1 })).toBe("");
  });
});
