import { readFileSync } from "node:fs";
import { join } from "node:path";
import { root } from "./paths.ts";

/** A row of tests/bench/results/NAME.csv. */
export interface Row {
  /** The machine on which it was measured. */
  machine: string;
  case: string;
  measure: string;
  unit: string;
  median: number;
  min: number;
  max: number;
}

/** The fields of a line of CSV; quoted ones may contain commas and doubled quotes. */
function fieldsOf(line: string): string[] {
  return [...line.matchAll(/(?:^|,)(?:"((?:[^"]|"")*)"|([^,]*))/g)].map(
    ([, quoted, plain]) => quoted?.replaceAll('""', '"') ?? plain ?? "",
  );
}

/** The newest row of each figure of a benchmark, for any machine and version. */
export function readResults(name: string): Row[] {
  return newestRows(readFileSync(join(root, "tests/bench/results", `${name}.csv`), "utf8"));
}

/** The rows of a table of results, without rows that a later run repeated. The newest rows are last. */
export function newestRows(text: string): Row[] {
  const rows = new Map<string, Row>();
  for (const row of allRows(text)) rows.set(`${row.case}\n${row.measure}\n${row.unit}`, row);
  return [...rows.values()];
}

function allRows(text: string): Row[] {
  const [header, ...lines] = text.trim().split("\n").map(fieldsOf);
  const column = (key: string) => header?.indexOf(key) ?? -1;
  return lines.map((fields) => ({
    machine: fields[column("machine")] ?? "",
    case: fields[column("case")] ?? "",
    measure: fields[column("measure")] ?? "",
    unit: fields[column("unit")] ?? "",
    median: Number(fields[column("median")]),
    min: Number(fields[column("min")]),
    max: Number(fields[column("max")]),
  }));
}
