/** A table in Markdown. */
export function markdown(rows: string[][]): string {
  return rows.map((row) => `| ${row.join(" | ")} |`).join("\n");
}

/** At least two significant digits, and all digits before the point: "0.40", "6.1", "178". */
export function short(value: number): string {
  return value >= 10 ? String(Math.round(value)) : value.toPrecision(2);
}

/** Like `short`, with groups of three digits and a unit: "17,800 MB". */
export function amount(value: number, unit = ""): string {
  const text = value >= 1000 ? Math.round(value).toLocaleString("en") : short(value);
  return unit ? `${text} ${unit}` : text;
}
