/** Formats numbers for display. */
import { localized } from "../../texts/numbers.ts";
import { pageTexts } from "../../texts/page.ts";

/** 1234567 → "1.23 M". */
export function formatCount(count: number): string {
  if (count < 1000) return String(Math.round(count));
  const units = ["k", "M", "G"];
  let value = count;
  let unit = -1;
  while (value >= 999.5 && unit < units.length - 1) {
    value /= 1000;
    unit += 1;
  }
  return localized(`${value.toPrecision(3)} ${units[unit]}`);
}

/** Decimal units: 523000 → "523 KB". */
export function formatBytes(bytes: number): string {
  if (bytes < 1000) return `${Math.round(bytes)} B`;
  const units = ["KB", "MB", "GB", "TB"];
  let value = bytes;
  let unit = -1;
  while (value >= 999.5 && unit < units.length - 1) {
    value /= 1000;
    unit += 1;
  }
  return localized(`${value.toPrecision(3)} ${units[unit]}`);
}

/** At most six significant digits, without trailing zeros: 60.500001 → "60.5". */
export function formatValue(value: number): string {
  return localized(plainValue(value));
}

/** The value of a field at a point: "temperature 305 K"; of a label that has a name: "region thalamus (10)". */
export function formatField({
  name,
  value,
  units,
  label,
}: {
  name: string;
  value: number;
  units?: string | undefined;
  label?: string | undefined;
}): string {
  if (label) return `${name} ${label} (${formatValue(value)})`;
  return [name, formatValue(value), units ?? ""].join(" ").trim();
}

/** As formatValue, but with a decimal point in every language, for file names. */
export function plainValue(value: number): string {
  if (!Number.isFinite(value)) return "–";
  return String(Number(value.toPrecision(6)));
}

/**
 * Parses a number with a decimal point or a decimal comma, independent of the browser's language.
 * If a text has both, the last one is the decimal sign and the other one separates groups
 * ("1.024,5" and "1,024.5"); a single one is the decimal sign. Undefined if it is not a number.
 */
export function parseValue(text: string): number | undefined {
  const plain = text.replace(/[\s'’_]/g, "").replace(/^\u2212/, "-");
  const [, sign = "", digits = "", exponent = ""] =
    /^([-+]?)([\d.,]+)(e[-+]?\d+)?$/i.exec(plain) ?? [];
  const signs = digits.replace(/\d/g, "");
  const last = signs.at(-1);
  // If one sign occurs several times, it separates groups, and there is no decimal sign.
  const isAllGrouping = signs.length > 1 && [...signs].every((each) => each === last);
  const decimal = last === undefined || isAllGrouping ? digits.length : digits.lastIndexOf(last);
  const grouping = isAllGrouping ? last : last === "." ? "," : ".";
  const [first = "", ...groups] = digits.slice(0, decimal).split(grouping ?? ",");
  if (groups.some((group) => !/^\d{3}$/.test(group))) return undefined;
  const whole = [first, ...groups].join("");
  const fraction = digits.slice(decimal + 1);
  if (!/^\d*$/.test(whole) || whole + fraction === "") return undefined;
  const value = Number(`${sign}${whole || "0"}.${fraction || "0"}${exponent}`);
  return Number.isFinite(value) ? value : undefined;
}

export function formatDims(voxels: readonly number[]): string {
  return voxels.join(" × ");
}

/**
 * How far the axes of a volume (columns, row-major) deviate from being perpendicular; undefined if
 * they are perpendicular within single precision.
 */
export function formatAxes(direction: readonly number[]): string | undefined {
  const cosine = (a: number, b: number): number =>
    [0, 3, 6].reduce((sum, row) => sum + (direction[row + a] ?? 0) * (direction[row + b] ?? 0), 0);
  const most = Math.max(...[cosine(0, 1), cosine(1, 2), cosine(2, 0)].map(Math.abs));
  const degrees = (Math.asin(Math.min(most, 1)) * 180) / Math.PI;
  return degrees < 0.01 ? undefined : pageTexts.notPerpendicular(localized(degrees.toFixed(1)));
}

/** "i16" → "16 bit signed". Other texts are returned unchanged. */
export function formatType(type: string | undefined): string {
  const [, letter, bits] = /^([uif])(8|16|32|64)$/.exec(type ?? "") ?? [];
  if (letter === "u") return pageTexts.bits(Number(bits));
  if (letter === "i") return pageTexts.signed(Number(bits));
  return letter === "f" ? pageTexts.float(Number(bits)) : (type ?? "");
}

/** A duration that remains, rounded up: "12 s", "3 min". */
export function formatDuration(seconds: number): string {
  return seconds < 90 ? `${Math.ceil(seconds)} s` : `${Math.ceil(seconds / 60)} min`;
}
