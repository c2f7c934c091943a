/** Numbers as people read them. */

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
  return `${value.toPrecision(3)} ${units[unit]}`;
}

/** Decimal units, as in the figures of the project: 523000 → "523 KB". */
export function formatBytes(bytes: number): string {
  if (bytes < 1000) return `${Math.round(bytes)} B`;
  const units = ["KB", "MB", "GB", "TB"];
  let value = bytes;
  let unit = -1;
  while (value >= 999.5 && unit < units.length - 1) {
    value /= 1000;
    unit += 1;
  }
  return `${value.toPrecision(3)} ${units[unit]}`;
}

/** Six significant digits at most, no trailing zeros: 60.500001 → "60.5". */
export function formatValue(value: number): string {
  if (!Number.isFinite(value)) return "–";
  return String(Number(value.toPrecision(6)));
}

export function formatDims(voxels: readonly number[]): string {
  return voxels.join(" × ");
}

const typeNames: Record<string, string> = {
  u8: "8 bit",
  i8: "8 bit signed",
  u16: "16 bit",
  i16: "16 bit signed",
  u32: "32 bit",
  i32: "32 bit signed",
  f32: "32 bit float",
  f64: "64 bit float",
};

export function formatType(type: string | undefined): string {
  return type === undefined ? "" : (typeNames[type] ?? type);
}
