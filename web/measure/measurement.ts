import type { Triple } from "../core/types.ts";
import { cross, dot } from "../viewer/vectors.ts";

export const measurementKinds = ["point", "distance", "path", "angle", "note"] as const;
export type MeasurementKind = (typeof measurementKinds)[number];

/**
 * A point in the world. The other properties of a pick are undefined if the point comes from a
 * link.
 */
export interface MeasuredPoint {
  position: Triple;
  /** The value at the point. */
  value?: number;
  /** World, of unit length. */
  normal?: Triple;
  /** Level of the picked cell: at 0 the point is exact. */
  level?: number;
  /** The title of the layer that was hit, if there were several, and the voxel of its volume. */
  layer?: string;
  voxel?: Triple;
  /** The field that colours showed, and its value at the point. */
  field?: MeasuredField;
}

export interface MeasuredField {
  name: string;
  value: number;
  units?: string;
  /** The name of the value, if values are labels. */
  label?: string;
}

export interface Measurement {
  kind: MeasurementKind;
  points: readonly MeasuredPoint[];
  /** A name, or the text of a note. */
  text?: string;
}

/** Limits for links and files. */
export const mostMeasurements = 500;
export const mostPoints = 500;
/** Limit for all measurements together. */
export const mostPointsInAll = 10_000;
export const longestText = 300;

/** The minimum and maximum number of points of each kind. */
export const pointCounts: Readonly<Record<MeasurementKind, readonly [number, number]>> = {
  point: [1, 1],
  distance: [2, 2],
  path: [2, mostPoints],
  angle: [3, 3],
  note: [1, 1],
};

/** The rule for texts in links, files and the page: those of notes are not empty. */
export function isText(kind: MeasurementKind, text: string): boolean {
  return text.length <= longestText && (kind !== "note" || text !== "");
}

/** The first measurements, up to the limits. */
export function withinLimits(measurements: readonly Measurement[]): readonly Measurement[] {
  let points = 0;
  const beyond = measurements.findIndex((each) => {
    points += each.points.length;
    return points > mostPointsInAll;
  });
  return measurements.slice(0, Math.min(mostMeasurements, beyond < 0 ? Infinity : beyond));
}

function minus(a: Triple, b: Triple): Triple {
  return [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
}

/** The length of the path through all points, in world units. */
export function lengthOf(points: readonly { position: Triple }[]): number {
  return points.reduce((sum, { position }, i) => {
    const before = points[i - 1];
    return before ? sum + Math.hypot(...minus(position, before.position)) : sum;
  }, 0);
}

/** The angle at the second of three points, in degrees; undefined if two of them coincide. */
export function angleOf(points: readonly { position: Triple }[]): number | undefined {
  const [a, corner, b] = points;
  if (!a || !corner || !b) return undefined;
  const [to, from] = [minus(a.position, corner.position), minus(b.position, corner.position)];
  if (Math.hypot(...to) === 0 || Math.hypot(...from) === 0) return undefined;
  // The arc tangent is precise for all angles; the arc cosine is not for small ones.
  return (Math.atan2(Math.hypot(...cross(to, from)), dot(to, from)) * 180) / Math.PI;
}

/** The position of the label: at the corner of an angle, in the middle of a distance, or at the last point. */
export function labelPoint({ kind, points }: Measurement): Triple | undefined {
  const [a, b] = points;
  if (kind === "angle") return b?.position;
  if (kind !== "distance" || !a || !b) return points.at(-1)?.position;
  const mean = (i: 0 | 1 | 2) => (a.position[i] + b.position[i]) / 2;
  return [mean(0), mean(1), mean(2)];
}

/** A point of the world in voxel coordinates of the volume. */
export function voxelOf(
  {
    origin,
    spacing,
    direction: d,
  }: { origin: Triple; spacing: Triple; direction: readonly number[] },
  position: Triple,
): Triple {
  const axis = (i: number): Triple => [d[i] ?? 0, d[3 + i] ?? 0, d[6 + i] ?? 0];
  const offset = minus(position, origin);
  const [x, y, z] = [axis(0), axis(1), axis(2)];
  const volume = dot(x, cross(y, z));
  // Cramer's rule: the axes need not be perpendicular.
  return [
    dot(offset, cross(y, z)) / volume / spacing[0],
    dot(offset, cross(z, x)) / volume / spacing[1],
    dot(offset, cross(x, y)) / volume / spacing[2],
  ];
}
