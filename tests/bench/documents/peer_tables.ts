/** Tables that compare Isosplat with other programs for browsers, from results/peers.csv. */
import { type Row, readResults } from "../harness/table.ts";
import { markdown, short } from "./markdown.ts";

const columns = [
  ["first picture", "s"],
  ["over the wire until the first picture", "MB"],
  ["final picture", "s"],
  ["over the wire until the final picture", "MB"],
  ["another isovalue, first picture", "s"],
  ["another isovalue, final picture", "s"],
  ["another isovalue, over the wire", "MB"],
  ["memory of the browser's processes, most", "MB"],
] as const;

type Values = Map<string, number>;

/** Programs by their names with versions, in the order of the results. */
type Programs = Map<string, Values>;

/** "engine 60.5", "20 Mbit/s, 40 ms", "vtk.js 37.4.3" */
const parts = /^(\S+ [\d.]+), (\d+ Mbit\/s, \d+ ms), (.+)$/;

/**
 * The headings of the tables, with their programs. Only the version of a program that was measured
 * last is included.
 */
function measured(rows: readonly Row[]): Map<string, Programs> {
  const tables = new Map<string, Programs>();
  for (const row of rows) {
    const [, surface, link, program] = parts.exec(row.case) ?? [];
    if (!surface || !link || !program) {
      throw new Error(`peers.csv: expected "VOLUME ISOVALUE, LINK, PROGRAM", found "${row.case}"`);
    }
    const heading = `${surface}, ${link}`;
    const programs = tables.get(heading) ?? new Map<string, Values>();
    tables.set(heading, programs);
    const withoutVersion = (name: string) => name.replace(/ \d+(\.\d+)+/g, "");
    for (const other of programs.keys()) {
      const isOlder = other !== program && withoutVersion(other) === withoutVersion(program);
      if (isOlder) programs.delete(other);
    }
    const values = programs.get(program) ?? new Map<string, number>();
    programs.set(program, values.set(row.measure, row.median));
  }
  return tables;
}

function valueIn(values: Values, measure: string, program: string): number {
  const value = values.get(measure);
  if (value === undefined)
    throw new Error(`peers.csv: expected a row "${measure}" of "${program}"`);
  return value;
}

const text = (value: number): string => (value === 0 ? "0" : short(value));

/** Lists the columns in which Isosplat is not the best, or states that there are none. */
function shortcomings(ours: string, programs: Programs): string {
  const own = programs.get(ours) ?? new Map();
  const found = columns.flatMap(([measure, unit]) => {
    const value = valueIn(own, measure, ours);
    const better = [...programs]
      .filter(([program, values]) => valueIn(values, measure, program) < value)
      .map(([program, values]) => `${program} ${text(valueIn(values, measure, program))} ${unit}`);
    return better.length ? [`${measure} (${text(value)} ${unit}): ${better.join("; ")}`] : [];
  });
  if (found.length === 0) return "No other program is faster or takes less in any column.";
  const list = found.map((line) => `- ${line}`).join("\n");
  return `Others are faster, or take less, than Isosplat (bold in the table) in:\n\n${list}`;
}

function table(heading: string, programs: Programs): string {
  const ours = [...programs.keys()].find((name) => name.startsWith("Isosplat "));
  if (!ours) throw new Error(`peers.csv: expected rows of Isosplat for "${heading}"`);
  const lines = [...programs].map(([program, values]) => [
    program,
    ...columns.map(([measure]) => {
      const value = valueIn(values, measure, program);
      const isBetter = value < valueIn(programs.get(ours) ?? new Map(), measure, ours);
      return isBetter ? `**${text(value)}**` : text(value);
    }),
  ]);
  const headings = [heading, ...columns.map(([measure, unit]) => `${measure}, ${unit}`)];
  const rows = [headings, headings.map(() => "---"), ...lines];
  return `${markdown(rows)}\n\n${shortcomings(ours, programs)}`;
}

/** A table for each volume and link, and the columns in which Isosplat is not the best. */
export function peerTables(rows: readonly Row[] = readResults("peers")): string {
  const tables = [...measured(rows)].map(([heading, programs]) => table(heading, programs));
  const machines = [...new Set(rows.map(({ machine }) => machine))].join("; ");
  return [...tables, `Measured without a GPU (Chromium draws with llvmpipe) on: ${machines}.`].join(
    "\n\n",
  );
}
