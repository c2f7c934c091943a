import { existsSync, mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import type { Machine } from "./machine.ts";
import { root } from "./paths.ts";

/** The goal of a figure. */
export type Reach = { atMost: number } | { atLeast: number };

/** One figure: several runs of one measure of one case. */
export interface Figure {
  /** The measured case, for example "engine 60.5, isosplat". */
  case: string;
  /** The measured property, for example "time", "bytes", "ratio to VTK". */
  measure: string;
  unit: string;
  /** One value per run, or a single value if it is the same in each run (bytes). */
  values: number[];
  reach?: Reach;
}

export function median(values: readonly number[]): number {
  const sorted = [...values].sort((a, b) => a - b);
  const middle = sorted.length >> 1;
  const upper = sorted[middle] ?? Number.NaN;
  return sorted.length % 2 ? upper : ((sorted[middle - 1] ?? Number.NaN) + upper) / 2;
}

/** Whether a figure reaches its goal; undefined if it has none. */
export function reached({ values, reach }: Figure): boolean | undefined {
  if (!reach) return undefined;
  const value = median(values);
  return "atMost" in reach ? value <= reach.atMost : value >= reach.atLeast;
}

/** Four significant digits, without an exponent if the number is readable. */
export function digits(value: number): string {
  if (!Number.isFinite(value)) return String(value);
  if (Math.abs(value) >= 1000) return Math.round(value).toLocaleString("en");
  return String(Number(value.toPrecision(4)));
}

/** The figures as a table of text. */
export function formatTable(figures: readonly Figure[]): string {
  const header = ["case", "measure", "median", "min", "max", "unit", "reach", ""];
  const rows = figures.map((figure) => {
    const { values, reach } = figure;
    const spread = values.length > 1;
    const met = reached(figure);
    return [
      figure.case,
      figure.measure,
      digits(median(values)),
      spread ? digits(Math.min(...values)) : "",
      spread ? digits(Math.max(...values)) : "",
      figure.unit,
      reach ? ("atMost" in reach ? `≤ ${digits(reach.atMost)}` : `≥ ${digits(reach.atLeast)}`) : "",
      met === undefined ? "" : met ? "reached" : "MISSED",
    ];
  });
  const widths = header.map((_, i) => Math.max(...[header, ...rows].map((r) => r[i]?.length ?? 0)));
  const numeric = new Set([2, 3, 4]);
  const line = (row: string[]) =>
    row
      .map((cell, i) =>
        numeric.has(i) ? cell.padStart(widths[i] ?? 0) : cell.padEnd(widths[i] ?? 0),
      )
      .join("  ")
      .trimEnd();
  return [line(header), line(widths.map((w) => "─".repeat(w))), ...rows.map(line)].join("\n");
}

const columns = [
  "version",
  "machine",
  "case",
  "measure",
  "unit",
  "median",
  "min",
  "max",
  "runs",
  "commit",
  "date",
] as const;

const quote = (cell: string) => (/[",\n]/.test(cell) ? `"${cell.replaceAll('"', '""')}"` : cell);

/**
 * The part of a row that identifies a figure: all fields except the measured values, commit and
 * date.
 */
const key = (line: string) =>
  (line.match(/^(?:"(?:[^"]|"")*"|[^,]*)(?:,(?:"(?:[^"]|"")*"|[^,]*)){4}/) ?? [""])[0];

/**
 * Adds the figures to tests/bench/results/NAME.csv, a row for each figure, version and machine.
 * Replaces rows of the same version and machine. Returns the file's path.
 */
export function saveResults(name: string, machine: Machine, figures: readonly Figure[]): string {
  const folder = join(root, "tests/bench/results");
  mkdirSync(folder, { recursive: true });
  const path = join(folder, `${name}.csv`);
  const date = new Date().toISOString().slice(0, 10);
  const added = figures.map(({ case: what, measure, unit, values }) =>
    [
      machine.version,
      machine.name,
      what,
      measure,
      unit,
      Number(median(values).toPrecision(6)),
      Number(Math.min(...values).toPrecision(6)),
      Number(Math.max(...values).toPrecision(6)),
      values.length,
      machine.commit,
      date,
    ]
      .map((cell) => quote(String(cell)))
      .join(","),
  );
  const before = existsSync(path) ? readFileSync(path, "utf8").trim().split("\n").slice(1) : [];
  const replaced = new Set(added.map(key));
  const kept = before.filter((line) => !replaced.has(key(line)));
  writeFileSync(path, `${[columns.join(","), ...kept, ...added].join("\n")}\n`);
  return path;
}
