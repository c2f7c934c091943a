import type { Triple } from "../stream/types.ts";
import {
  longestText,
  type MeasuredPoint,
  type Measurement,
  measurementKinds,
  pointCounts,
} from "./measurement.ts";

/**
 * A measurement as text, as the parameters `measure` of the page's address have it:
 * `kind,x,y,z[,x,y,z …]`, and after a `|` its text. Positions are world coordinates, with as many
 * digits as single precision has.
 */
export function writeMeasurement({ kind, points, text }: Measurement): string {
  const numbers = points.flatMap(({ position }) => position.map((n) => Number(n.toPrecision(8))));
  return [kind, ...numbers].join(",") + (text ? `|${text}` : "");
}

/** Undefined if the text is not that of a measurement. */
export function readMeasurement(line: string): Measurement | undefined {
  const bar = line.indexOf("|");
  const [name, ...parts] = (bar < 0 ? line : line.slice(0, bar)).split(",");
  const kind = measurementKinds.find((known) => known === name);
  const numbers = parts.map((part) => (part.trim() === "" ? Number.NaN : Number(part)));
  if (!kind || !numbers.every(Number.isFinite) || numbers.length % 3 !== 0) return undefined;
  const points: MeasuredPoint[] = [];
  for (let i = 0; i < numbers.length; i += 3) {
    points.push({ position: numbers.slice(i, i + 3) as Triple });
  }
  const [least, most] = pointCounts[kind];
  if (points.length < least || points.length > most) return undefined;
  const text = bar < 0 ? "" : line.slice(bar + 1);
  if (text.length > longestText || (kind === "note" && text === "")) return undefined;
  return { kind, points, ...(text !== "" && { text }) };
}

/** Text for a cell of a table. Spreadsheets run text that begins so as a formula. */
function cell(text: string): string {
  const safe = /^[=+\-@\t\r]/.test(text) ? `'${text}` : text;
  return /[",\n\r]/.test(safe) ? `"${safe.replace(/"/g, '""')}"` : safe;
}

/** What a table or a file says of a measurement. */
export interface MeasurementRow extends Measurement {
  length?: number;
  angle?: number;
  voxels: readonly Triple[];
}

/** One line for each point. Lengths are in world units, angles in degrees. */
export function toCsv(rows: readonly MeasurementRow[]): string {
  const head =
    "number,kind,text,point,x,y,z,voxel_x,voxel_y,voxel_z,value,normal_x,normal_y,normal_z";
  const lines = rows.flatMap(({ kind, text = "", points, voxels, length, angle }, i) =>
    points.map(({ position, value, normal }, j) =>
      [
        i + 1,
        kind,
        cell(text),
        j + 1,
        ...position,
        ...(voxels[j] ?? ["", "", ""]),
        value ?? "",
        ...(normal ?? ["", "", ""]),
        j === 0 ? (length ?? "") : "",
        j === 0 ? (angle ?? "") : "",
      ].join(","),
    ),
  );
  return `${[`${head},length,angle`, ...lines].join("\r\n")}\r\n`;
}
