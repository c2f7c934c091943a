import type { FieldInfo, StoreInfo } from "../core/types.ts";
import type { FieldLook, FieldScale } from "./types.ts";

/** The field of a store with this name. */
export function fieldOf({ fields }: StoreInfo, name: string): FieldInfo | null {
  return fields.find((field) => field.name === name) ?? null;
}

/** A look that can be drawn: without contour lines, unless their distance is a number above 0. */
export function usableField(field: FieldLook): FieldLook {
  const { lines } = field;
  return lines === 0 || (Number.isFinite(lines) && lines > 0) ? field : { ...field, lines: 0 };
}

/** The range; if both ends are the same value, a range around it. */
export function distinct([low, high]: readonly [number, number]): [number, number] {
  if (low < high) return [low, high];
  const around = Math.abs(low) / 100 || 1;
  return [low - around, low + around];
}

/** The values of the first and the last colour: field_range in shared/render/settings/render_settings.h. */
export function shownRange(
  [low, high]: readonly [number, number],
  scale: FieldScale,
): [number, number] {
  if (scale === "symmetric") {
    const most = Math.max(Math.abs(low), Math.abs(high));
    return [-most, most];
  }
  if (scale === "linear") return [low, high];
  const top = high > 0 ? high : 1;
  return [low > 0 ? low : top / 1000, top];
}
