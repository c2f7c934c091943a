import type { Respacing } from "../viewer/respacing.ts";
import type { Measurement } from "./measurement.ts";

/** A measurement whose points move along with the voxels of their volume. Values and levels stay. */
export function movedMeasurement(
  measurement: Measurement,
  { point, plane }: Pick<Respacing, "point" | "plane">,
): Measurement {
  const points = measurement.points.map((each) => ({
    ...each,
    position: point(each.position),
    ...(each.normal && { normal: plane({ normal: each.normal, offset: 0 }).normal }),
  }));
  return { ...measurement, points };
}
