import type { MeasuredPoint, Measurement } from "../../measure/measurement.ts";
import { measureTexts } from "../../texts/measure.ts";
import { sameValue } from "../../viewer/same_value.ts";

/** What a change of measurements is told by. */
export interface Measured {
  measurements: readonly Measurement[];
  /** The points of the unfinished measurement. */
  draft: readonly MeasuredPoint[];
}

/**
 * What screen readers say of a change of the measurements; undefined if there is none. `resultOf`: the result of a
 * measurement, as the picture shows it.
 */
export function announcementOf(
  before: Measured,
  after: Measured,
  resultOf: (measurement: Measurement) => string,
): string | undefined {
  const [old, now] = [before.measurements, after.measurements];
  // The first place where they differ.
  const at = now.findIndex((each, i) => !sameValue(each, old[i]));
  if (at < 0 && now.length === old.length) {
    const { length } = after.draft;
    return length === before.draft.length ? undefined : measureTexts.pointsSet(length);
  }
  const changed = at < 0 ? now.length : at;
  const rest = (all: readonly Measurement[], from: number) => all.slice(from);
  const [first, removed] = [now[changed], old[changed]];
  if (first && sameValue(rest(now, changed + 1), rest(old, changed))) {
    return `${measureTexts.kinds[first.kind]}: ${resultOf(first)}`;
  }
  if (first && sameValue(rest(now, changed + 1), rest(old, changed + 1))) {
    return `${measureTexts.kinds[first.kind]} ${changed + 1}: ${resultOf(first)}`;
  }
  const isOneLess = sameValue(rest(now, changed), rest(old, changed + 1));
  if (removed && isOneLess && old.length > 1) {
    return measureTexts.isRemoved(`${measureTexts.kinds[removed.kind]} ${changed + 1}`);
  }
  return measureTexts.count(now.length);
}
