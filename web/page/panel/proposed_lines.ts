import { fittingInterval } from "../../viewer/field_lines.ts";
import { shownRange } from "../../viewer/field_of.ts";
import type { FieldLook, FieldScale } from "../../viewer/types.ts";

/** The distance of contour lines that the panel proposes for a range of colours. */
export function proposedLines(range: readonly [number, number], scale: FieldScale): number {
  return fittingInterval(shownRange(range, scale), scale);
}

/**
 * The look `after` a change of range or scale: an interval that was proposed follows both, one that was entered stays,
 * unless another scale gives it another meaning. `whole`: the range of the field, which the look has instead of null.
 */
export function withFollowingLines(
  after: FieldLook,
  before: FieldLook,
  whole: readonly [number, number],
): FieldLook {
  const proposed = ({ range, scale }: FieldLook) => proposedLines(range ?? whole, scale);
  const isEntered = after.lines !== before.lines || after.name !== before.name;
  if (after.lines === 0 || isEntered) return after;
  const isLogarithm = ({ scale }: FieldLook) => scale === "logarithmic";
  const keeps = isLogarithm(after) === isLogarithm(before) && before.lines !== proposed(before);
  return keeps ? after : { ...after, lines: proposed(after) };
}
