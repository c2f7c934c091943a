// Distances between voxels that a visitor enters, in their units.
import { afterEach, beforeEach, expect, it, vi } from "vitest";
import type { Triple } from "../../web/core/types.ts";
import { inUnit, millimetresOf } from "../../web/page/address/spacing_units.ts";
import { keepSpacing, keptSpacing } from "../../web/page/volume/kept_spacing.ts";

beforeEach(() => {
  const items = new Map<string, string>();
  vi.stubGlobal("localStorage", {
    getItem: (key: string) => items.get(key) ?? null,
    setItem: (key: string, value: string) => items.set(key, value),
    removeItem: (key: string) => items.delete(key),
  });
});
afterEach(() => vi.unstubAllGlobals());

it("are millimetres without rounding errors", () => {
  expect(millimetresOf({ lengths: [0.3, 0.7, 1.1], unit: "µm" })).toEqual([0.0003, 0.0007, 0.0011]);
  expect(millimetresOf({ lengths: [3, 2.5, 7], unit: "Å" })).toEqual([3e-7, 2.5e-7, 7e-7]);
});

it.each<[Triple, Triple, string]>([
  [[0.0005, 0.0005, 0.0005], [0.5, 0.5, 0.5], "µm"],
  [[0.25, 0.25, 1.2], [0.25, 0.25, 1.2], "mm"],
  [[0.0003, 0.0003, 0.009], [0.3, 0.3, 9], "µm"],
  [[3e-7, 3e-7, 3e-7], [0.3, 0.3, 0.3], "nm"],
  [[1e-12, 1, 1], [1e-6, 1e6, 1e6], "nm"],
])("of %j mm are shown as %j %s", (spacing, lengths, unit) => {
  expect(inUnit(spacing)).toEqual({ lengths, unit });
});

it("are kept with their unit, and forgotten", () => {
  const entered = { lengths: [0.5, 0.5, 12] as Triple, unit: "nm" as const };
  keepSpacing("abc", entered);
  expect(keptSpacing("abc")).toEqual(entered);
  expect(keptSpacing("abd")).toBeUndefined();
  keepSpacing("abc", undefined);
  expect(keptSpacing("abc")).toBeUndefined();
});

it("are kept where earlier versions do not read them, and replace what those kept", () => {
  localStorage.setItem("isosplat-spacing-abc", "1,1,1");
  keepSpacing("abc", { lengths: [0.5, 0.5, 12], unit: "nm" });
  expect(localStorage.getItem("isosplat-spacing-abc")).toBeNull();
  keepSpacing("abc", undefined);
  expect(keptSpacing("abc")).toBeUndefined();
  localStorage.setItem("isosplat-spacing-abc", "1,1,1");
  keepSpacing("abc", undefined);
  expect(keptSpacing("abc")).toBeUndefined();
});

it("of earlier versions are in millimetres", () => {
  localStorage.setItem("isosplat-spacing-abc", "0.0005,0.0005,0.001");
  expect(keptSpacing("abc")).toEqual({ lengths: [0.5, 0.5, 1], unit: "µm" });
  for (const wrong of ["", "1,2", "1,0,1", "a,b,c,mm", "1,1,-1,mm"]) {
    localStorage.setItem("isosplat-spacing-abc", wrong);
    expect(keptSpacing("abc")).toBeUndefined();
  }
  localStorage.setItem("isosplat-spacing-abc", "1,1,1,constructor");
  expect(keptSpacing("abc")).toEqual({ lengths: [1, 1, 1], unit: "mm" });
});
