import type { Triple } from "../core/types.ts";
import type { LengthUnit } from "../overlay/length_unit.ts";
import {
  isText,
  type MeasuredPoint,
  type Measurement,
  measurementKinds,
  pointCounts,
} from "./measurement.ts";

/**
 * A measurement as text, in the form of the parameter `measure` of the page's address:
 * `kind,x,y,z[,x,y,z …]`, and after a `|` its text. Positions are world coordinates, with eight
 * digits. `kind@2` means that the coarsest cell of its points has level 2, so the points are not
 * exact. Values and normals are left out.
 */
export function writeMeasurement({ kind, points, text }: Measurement): string {
  const numbers = points.flatMap(({ position }) => position.map((n) => Number(n.toPrecision(8))));
  const level = levelOf(points);
  return [level > 0 ? `${kind}@${level}` : kind, ...numbers].join(",") + (text ? `|${text}` : "");
}

/** The coarsest level of its cells; 0 if all points are exact, or the level is not known. */
export function levelOf(points: readonly MeasuredPoint[]): number {
  return Math.max(0, ...points.map(({ level = 0 }) => level));
}

/** Undefined if the text is not a measurement. */
export function readMeasurement(line: string): Measurement | undefined {
  const bar = line.indexOf("|");
  const [head = "", ...parts] = (bar < 0 ? line : line.slice(0, bar)).split(",");
  const [, name, digits] = /^([a-z]+)(?:@([1-9]\d?))?$/.exec(head) ?? [];
  const kind = measurementKinds.find((known) => known === name);
  const level = digits ? { level: Number(digits) } : {};
  const numbers = parts.map((part) => (part.trim() === "" ? Number.NaN : Number(part)));
  if (!kind || !numbers.every(Number.isFinite) || numbers.length % 3 !== 0) return undefined;
  const points: MeasuredPoint[] = [];
  for (let i = 0; i < numbers.length; i += 3) {
    points.push({ position: numbers.slice(i, i + 3) as Triple, ...level });
  }
  const [least, most] = pointCounts[kind];
  if (points.length < least || points.length > most) return undefined;
  const text = bar < 0 ? "" : line.slice(bar + 1);
  if (!isText(kind, text)) return undefined;
  return { kind, points, ...(text !== "" && { text }) };
}

/** Text for a cell of a table. Spreadsheets would run some texts as formulas. */
function cell(text: string): string {
  const safe = /^[=+\-@\t\r]/.test(text) ? `'${text}` : text;
  return /[",\n\r]/.test(safe) ? `"${safe.replace(/"/g, '""')}"` : safe;
}

/** A measurement in a table or a file. */
export interface MeasurementRow extends Measurement {
  length_mm?: number;
  /** Instead of `length_mm` if the size of a voxel is unknown. */
  length_voxels?: number;
  angle_degrees?: number;
  voxels: readonly Triple[];
}

/**
 * One line for each point; with a column `layer` if there were several, and with columns of the field where one was
 * shown. `unit`: of the world's lengths.
 */
export function toCsv(rows: readonly MeasurementRow[], unit: LengthUnit = "mm"): string {
  const of = unit === "mm" ? "mm" : "voxels";
  const hasLayers = rows.some(({ points }) => points.some(({ layer }) => layer !== undefined));
  const hasFields = rows.some(({ points }) => points.some(({ field }) => field !== undefined));
  const head =
    `number,kind,text,point,x_${of},y_${of},z_${of},voxel_x,voxel_y,voxel_z,value,` +
    `normal_x,normal_y,normal_z,level,length_${of},angle_degrees${hasLayers ? ",layer" : ""}` +
    (hasFields ? ",field,field_value,field_units" : "");
  const lines = rows.flatMap(({ kind, text = "", points, voxels, ...results }, i) =>
    points.map(({ position, value, normal, level, layer = "", field }, j) =>
      [
        i + 1,
        kind,
        cell(text),
        j + 1,
        ...position,
        ...(voxels[j] ?? ["", "", ""]),
        value ?? "",
        ...(normal ?? ["", "", ""]),
        level ?? "",
        j === 0 ? (results.length_mm ?? results.length_voxels ?? "") : "",
        j === 0 ? (results.angle_degrees ?? "") : "",
        ...(hasLayers ? [cell(layer)] : []),
        ...(hasFields
          ? [cell(field?.name ?? ""), field?.value ?? "", cell(field?.units ?? "")]
          : []),
      ].join(","),
    ),
  );
  return `${[head, ...lines].join("\r\n")}\r\n`;
}
