import type { Triple } from "../../core/types.ts";

/** Units in which distances between voxels can be entered, in millimetres. */
const units = { mm: 1, µm: 1e-3, nm: 1e-6, Å: 1e-7, cm: 10, m: 1000 };

export type SpacingUnit = keyof typeof units;
export const spacingUnits = Object.keys(units) as SpacingUnit[];

/** Distances between voxels as a visitor enters them. */
export interface UnitSpacing {
  lengths: Triple;
  unit: SpacingUnit;
}

export function isSpacingUnit(text: string | undefined): text is SpacingUnit {
  return text !== undefined && Object.hasOwn(units, text);
}

/** Single precision has seven digits; the rounding errors of a change of unit are in the sixteenth. */
function rounded(length: number): number {
  return Number(length.toPrecision(14));
}

export function millimetresOf({ lengths, unit }: UnitSpacing): Triple {
  return lengths.map((length) => rounded(length * units[unit])) as Triple;
}

/** `unit`: by default mm, µm or nm, the largest one in which no distance is below a tenth. */
export function inUnit(spacing: Triple, unit = unitFor(spacing)): UnitSpacing {
  return { lengths: spacing.map((length) => rounded(length / units[unit])) as Triple, unit };
}

function unitFor(spacing: Triple): SpacingUnit {
  const least = Math.min(...spacing);
  const all = ["mm", "µm", "nm"] as const;
  return all.find((unit) => least >= units[unit] / 10) ?? "nm";
}
