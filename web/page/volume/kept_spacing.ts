import { inUnit, isSpacingUnit, type UnitSpacing } from "../panel/spacing_units.ts";

/**
 * Followed by the content id of a store, in localStorage: the spacing that the visitor has entered for it, as three
 * numbers and their unit: "0.5,0.5,1,µm". Without a unit: in mm.
 */
const keptKey = "isosplat-spacing-";

export function keepSpacing(contentId: string, { lengths, unit }: UnitSpacing): void {
  try {
    localStorage.setItem(keptKey + contentId, [...lengths, unit].join(","));
  } catch {
    // Storage may be full or disabled. The address has the spacing.
  }
}

export function forgetSpacing(contentId: string): void {
  try {
    localStorage.removeItem(keptKey + contentId);
  } catch {
    // Nothing was kept.
  }
}

export function keptSpacing(contentId: string): UnitSpacing | undefined {
  try {
    const parts = (localStorage.getItem(keptKey + contentId) ?? "").split(",");
    const [x = 0, y = 0, z = 0] = parts.map(Number);
    if (!(x > 0 && y > 0 && z > 0)) return undefined;
    const unit = parts[3];
    return isSpacingUnit(unit) ? { lengths: [x, y, z], unit } : inUnit([x, y, z]);
  } catch {
    return undefined; // storage may be disabled
  }
}
