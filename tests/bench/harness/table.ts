import { readFileSync } from "node:fs";
import { join } from "node:path";
import { root } from "./paths.ts";

/** A row of tests/bench/results/NAME.csv. */
export interface Row {
  /** Where it was measured. */
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

/** The rows of a benchmark's results, of all machines and versions, newest last. */
export function readResults(name: string): Row[] {
  const text = readFileSync(join(root, "tests/bench/results", `${name}.csv`), "utf8");
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
