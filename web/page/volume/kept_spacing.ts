import { inUnit, isSpacingUnit, type UnitSpacing } from "../address/spacing_units.ts";

/**
 * Followed by the content id of a store, in localStorage: the spacing that the visitor has entered for it, as three
 * numbers and their unit: "0.5,0.5,1,µm".
 */
const keptKey = "isosplat-entered-spacing-";
/** As earlier pages kept it: three numbers in mm. */
const earlierKey = "isosplat-spacing-";

/** Undefined: nothing is kept any more. */
export function keepSpacing(contentId: string, entered: UnitSpacing | undefined): void {
  if (!entered) {
    forgetSpacing(contentId);
    return;
  }
  const { lengths, unit } = entered;
  try {
    localStorage.setItem(keptKey + contentId, [...lengths, unit].join(","));
    localStorage.removeItem(earlierKey + contentId);
  } catch {
    // Storage may be full or disabled. The address has the spacing.
  }
}

function forgetSpacing(contentId: string): void {
  try {
    localStorage.removeItem(keptKey + contentId);
    localStorage.removeItem(earlierKey + contentId);
  } catch {
    // Nothing was kept.
  }
}

export function keptSpacing(contentId: string): UnitSpacing | undefined {
  try {
    const kept =
      localStorage.getItem(keptKey + contentId) ?? localStorage.getItem(earlierKey + contentId);
    const parts = (kept ?? "").split(",");
    const [x = 0, y = 0, z = 0] = parts.map(Number);
    if (!(x > 0 && y > 0 && z > 0)) return undefined;
    const unit = parts[3];
    return isSpacingUnit(unit) ? { lengths: [x, y, z], unit } : inUnit([x, y, z]);
  } catch {
    return undefined; // storage may be disabled
  }
}
