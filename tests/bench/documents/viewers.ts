/** Tables of docs/scale.md: the simulated requests of many viewers through a cache. */
import { type Row, readResults } from "../harness/table.ts";
import { amount, markdown } from "./markdown.ts";

/** Caches of one size. */
interface Run {
  viewers: string;
  cache: string;
  isCalculated: boolean;
  rows: Row[];
}

/** The runs in the order of their measurement: with nginx, then by calculation. */
export function viewerRuns(): Run[] {
  const runs = new Map<string, Run>();
  for (const row of readResults("viewers")) {
    const [, viewers, calculated, cache] =
      /^([\d,]+) viewers, (calculated, )?(.*)$/.exec(row.case) ?? [];
    if (!viewers || !cache) continue;
    const run = runs.get(row.case) ?? {
      ...{ viewers, cache, isCalculated: calculated !== undefined, rows: [] },
    };
    run.rows.push(row);
    runs.set(row.case, run);
  }
  return [...runs.values()];
}

/** A figure of a run; undefined if there is no such row. */
export function figureOf({ rows }: Run, measure: string, unit: string): number | undefined {
  return rows.find((row) => row.measure === measure && row.unit === unit)?.median;
}

/** Heading, measure and unit of the rows of the table. */
const lines = [
  ["come within, minutes", "time of arrivals", "minutes"],
  ["requests", "requests", ""],
  ["to the viewers, GB", "to the viewers", "GB"],
  ["hits, % of the requests", "hits, of requests", "%"],
  ["hits, % of the bytes", "hits, of bytes", "%"],
  ["from the server, requests", "from the server", "requests"],
  ["from the server, MB", "from the server", "MB"],
  [
    "of them first answers (`bootstrap`), MB",
    "from the server, /v1/volumes/{name}/bootstrap",
    "MB",
  ],
  ["from the server, requests per second", "from the server, on average", "requests/s"],
  ["the same, most in a second", "from the server, at most", "requests/s"],
  ["refused for their rate (429)", "refused (429)", "requests"],
  ["failed", "failed", "requests"],
  ["latency, median, ms", "latency, median", "ms"],
  ["latency, 99th percentile, ms", "latency, 99th percentile", "ms"],
  ["sent late, 99th percentile, ms", "sent late, 99th percentile", "ms"],
  ["files of the cache, at the end, MB", "files of the cache, at the end", "MB"],
  ["files of the cache, at most, MB", "files of the cache, at most", "MB"],
] as const;

/** The replays through nginx, and the calculated caches that keep everything. */
export function replayTable(): string {
  const runs = viewerRuns().filter(
    ({ isCalculated, cache }) => !isCalculated || cache.endsWith("unlimited cache"),
  );
  const title = ({ viewers, cache, isCalculated }: Run) =>
    `${viewers} viewers, ${cache}${isCalculated ? ", calculated" : ""}`;
  const heading = ["", ...runs.map(title)];
  const body = lines.map(([name, measure, unit]) => [
    name,
    ...runs.map((run) => {
      const figure = figureOf(run, measure, unit);
      return figure ? amount(figure) : String(figure ?? "");
    }),
  ]);
  return markdown([heading, heading.map(() => "---"), ...body]);
}

/** Statistics of the recorded visits. */
export function visitsTable(): string {
  const rows = readResults("viewers").filter(
    (row) => /visits|the page|stores/.test(row.case) && !/viewers/.test(row.case),
  );
  const heading = ["", "", "median", "least", "most"];
  const body = rows.map((row) => [
    row.case,
    row.unit ? `${row.measure}, ${row.unit}` : row.measure,
    amount(row.median),
    ...(row.min === row.max ? ["", ""] : [amount(row.min), amount(row.max)]),
  ]);
  return markdown([heading, heading.map(() => "---"), ...body]);
}
