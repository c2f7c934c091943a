import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { root } from "../harness/paths.ts";
import { readResults } from "../harness/table.ts";
import { ewaTable } from "./ewa_table.ts";
import { growthTable } from "./growth.ts";
import { markdown, short } from "./markdown.ts";
import { peerTables } from "./peer_tables.ts";
import { rankAssumptions, rankPartsTable, ranksTable, twoRanks } from "./ranks.ts";
import { assumptions, checks, limits, viewersPlan, volumePlan } from "./scale.ts";
import { replayTable, visitsTable } from "./viewers.ts";

/** A table of a document, between <!-- NAME --> and <!-- end -->. */
export interface DocumentTable {
  /** Relative to the project. */
  file: string;
  name: string;
  /** In Markdown. */
  table: string;
}

/** The newest results, as text. Records the machines on which their times were measured. */
class Figures {
  readonly machines = new Set<string>();

  /** The medians of a measure, in a unit, for several cases: "61; 73; 76". */
  of(benchmark: string, cases: string[], measure: string, unit: string, scale = 1): string {
    const rows = readResults(benchmark);
    const values = cases.map((what) => {
      const row = rows.find((r) => r.case === what && r.measure === measure && r.unit === unit);
      if (!row) {
        throw new Error(`${benchmark}.csv: expected a row "${measure}" in "${unit}" of "${what}"`);
      }
      if (/(^|\/)m?s$/.test(row.unit)) this.machines.add(row.machine);
      return short(scale * row.median);
    });
    return values.join("; ");
  }
}

/** The waiting times and downloads of a visitor. */
function networkFigures(figures: Figures): string {
  const link = "20 Mbit/s, 40 ms";
  const value = (what: string, measure: string, unit: string) =>
    `${figures.of("stream", [what], measure, unit)} ${unit}`;
  const surface = (volume: string) => value(`${volume}, ${link}`, "until the first surface", "KB");
  const complete = (volume: string) => value(`${volume}, ${link}`, "until complete", "MB");
  const [engine, bunny, fractal] = ["engine 60.5", "bunny_ct_i16 1000.5", "mandelbulb1024 226.5"];
  const vtk = `${engine}, ${link}, vtk.js`;
  const page = (measure: string) =>
    `${figures.of("page_size", ["the page, nothing cached"], measure, "KB")} KB`;
  const anotherIsovalue = (program: string) => {
    const begin = `${engine}, ${link}, ${program} `;
    const found = readResults("peers").find((row) => row.case.startsWith(begin));
    const of = (picture: string) =>
      figures.of("peers", [found?.case ?? begin], `another isovalue, ${picture} picture`, "s");
    return `${of("first")} s; ${of("final")} s`;
  };
  return markdown([
    ["network: 20 Mbit/s, 40 ms delay", "volume", "Isosplat", "for comparison"],
    ["---", "---", "---", "---"],
    [
      "first image, nothing cached; data until then",
      "engine",
      `${value(`${engine}, ${link}`, "first surface, nothing cached", "s")}; ${surface(engine)}`,
      `vtk.js: ${value(vtk, "first image, nothing cached", "s")}; ${value(vtk, "volume over the wire", "MB")}`,
    ],
    [
      "bytes of the page itself until then; with all its controls",
      "engine",
      `${page("until the first surface")}; ${page("with all controls")}`,
      "",
    ],
    [
      "another isovalue: first picture; final picture",
      "engine",
      anotherIsovalue("Isosplat"),
      `vtk.js: ${anotherIsovalue("vtk.js")}`,
    ],
    [
      "bytes until the picture is complete",
      "engine",
      complete(engine),
      `whole volume, compressed: ${value(vtk, "volume over the wire", "MB")}`,
    ],
    [
      "bytes of the first surface; until complete",
      "bunny CT, isovalue 1000.5",
      `${surface(bunny)}; ${complete(bunny)}`,
      `voxels: 189 MB`,
    ],
    [
      "bytes of the first surface; until complete",
      "fractal",
      `${surface(fractal)}; ${complete(fractal)}`,
      "voxels: 1,074 MB",
    ],
  ]);
}

/** Sizes of stores, and rates of the native program. */
function programFigures(figures: Figures): string {
  const volumes = "engine; bonsai; bunny CT";
  const surfaces = ["engine 60.5", "bonsai 40.5", "bunny_ct_i16 1000.5"];
  const bunny = ["bunny_ct_i16"];
  return markdown([
    ["program", "volume", "Isosplat", "for comparison"],
    ["---", "---", "---", "---"],
    [
      "store, bytes ÷ bytes of the voxels",
      "engine; bunny CT; noisy MR of a head",
      figures.of("store_size", ["engine", "bunny_ct_i16", "chris_t1"], "store / raw", ""),
      "",
    ],
    [
      "building a store, million voxels per second",
      volumes,
      figures.of("build", ["engine", "bonsai", "bunny_ct_i16"], "rate", "Mvoxel/s"),
      "",
    ],
    [
      "samples that can be drawn, two threads",
      volumes,
      `${figures.of("extract", surfaces, "Isosplat, 2 threads", "ms")} ms`,
      `VTK's Flying Edges: ${figures.of("extract", surfaces, "Flying Edges, 2 threads (TBB)", "ms")} ms`,
    ],
    [
      "decoding, one core, million samples per second",
      "bunny CT",
      `${figures.of("decode", bunny, "native", "Msamples/s")}; as WebAssembly ${figures.of("decode", bunny, "WASM in Node", "Msamples/s")}`,
      "",
    ],
  ]);
}

/** The cases of floods.bench.ts. */
const floods = [
  "1,024 slow readers of four addresses, 100 B/s each",
  "1,024 slow headers of four addresses, 1 B/s each",
  "1,500 stalled handshakes/s of eight addresses, HTTP",
  "1,500 stalled handshakes/s of eight addresses, TLS",
  "one address with 64 connections that ask for chunks",
  "40 loops of samples of one address",
  "4 × 360 pipelined /healthz per second, 20,000 stores",
];

/** Rates of the server compared with nginx, and its behaviour with many clients. */
function serverFigures(figures: Figures): string {
  const ratio = (what: string) => figures.of("server", [what], "rate, ratio to nginx", "×");
  const chunk = (bytes: number) => {
    const what = `chunk of ${bytes} bytes`;
    return `${ratio(what)}; ${ratio(`${what}, TLS`)}`;
  };
  const cost = (bytes: number) =>
    figures.of("server", [`chunk of ${bytes} bytes`], "processor time, ratio to nginx", "×");
  const surface = "bunny at 1000.5, 4.7 MB";
  const idle = "5000 idle connections and 100 busy";
  const slow = "2,000 slow readers, 500 slow headers";
  const megabytes = figures.of("server", [idle], "RSS", "MB");
  const flooded = (from: number, to: number) =>
    figures.of("floods", floods.slice(from, to), "ratio", "×");
  const late = figures.of("server", [idle], "99th percentile, ratio", "×");
  return markdown([
    ["server, on the same two cores as its clients", "Isosplat", "for comparison: nginx"],
    ["---", "---", "---"],
    ["rate of requests for a chunk of 4 KB, ÷ nginx's; with TLS", chunk(4021), "1"],
    ["rate of requests for a chunk of 20 KB, ÷ nginx's; with TLS", chunk(20378), "1"],
    [
      "processor time of a request for a chunk of 4 KB; of 20 KB, ÷ nginx's",
      `${cost(4021)}; ${cost(20378)}`,
      "1",
    ],
    [
      "all chunks of bunny CT's isovalue 1000.5, one connection",
      `${figures.of("server", [`${surface}, isosplat`], "rate", "GB/s")} GB/s`,
      `${figures.of("server", [`${surface}, nginx`], "rate", "GB/s")} GB/s, one file`,
    ],
    [
      "beside 5,000 idle connections: memory; latency of 100 busy ones (99th percentile), ÷ that without",
      `${megabytes} MB; ${late}`,
      "",
    ],
    [
      "beside 2,000 clients that read slowly and 500 that send headers slowly: rate of others, ÷ that without",
      figures.of("server", [slow], "honest clients' rate, ratio", "×"),
      "",
    ],
    [
      "another client's rate, ÷ that without, beside 1,024 slow readers; 1,024 slow headers; 1,500 stalled handshakes/s, HTTP; the same, TLS",
      flooded(0, 4),
      "",
    ],
    [
      "the same, beside one address that asks for chunks, 64 at a time; for samples, 40 at a time; 1,440 pipelined /healthz per second, 20,000 stores",
      flooded(4, 7),
      "",
    ],
    [
      "10,000 stores: ready after",
      `${figures.of("server", ["10000 stores"], "ready after", "s")} s`,
      "",
    ],
  ]);
}

/** Frame rates and errors of pictures. */
function pictureFigures(figures: Figures): string {
  const volumes = ["engine 60.5", "bonsai 40.5"];
  const of = (suffix: string) => volumes.map((volume) => `${volume}${suffix}`);
  const fidelity = (kind: string, measure: string, unit: string, scale = 1) =>
    figures.of("fidelity", of(`, front, ${kind}`), measure, unit, scale);
  return markdown([
    ["picture", "volume, isovalue", "Isosplat", "for comparison: Flying Edges mesh, same renderer"],
    ["---", "---", "---", "---"],
    [
      "frames per second, quads, whole volume in view, relative to the mesh",
      volumes.join("; "),
      figures.of("frame_rate", of(", quad"), "frames per mesh frame", "×"),
      "1",
    ],
    ...(["quad", "exact", "smooth"] as const).map((kind) => [
      `the same close up, ${{ quad: "quads", exact: "exact splats", smooth: "exact splats, smooth shading" }[kind]}`,
      volumes.join("; "),
      figures.of("frame_rate", of(`, ${kind}`), "close-up: frames per mesh frame", "×"),
      "1",
    ]),
    [
      "error of normals, exact splats, against a ray caster, degrees",
      volumes.join("; "),
      fidelity("exact", "normal error", "°"),
      fidelity("mesh", "normal error", "°"),
    ],
    [
      "error of the outline, percent of the area",
      volumes.join("; "),
      fidelity("exact", "outline", "of area", 100),
      fidelity("mesh", "outline", "of area", 100),
    ],
  ]);
}

/** The medians of a measure over all volumes. */
function mediansOf(benchmark: string, measure: RegExp, cases = /./): number[] {
  return readResults(benchmark)
    .filter((row) => measure.test(row.measure) && cases.test(row.case))
    .map(({ median }) => median);
}

/** "0.10–0.21 × (6 volumes)". */
function rangeText(values: number[]): string {
  const [low, high] = [Math.min(...values), Math.max(...values)].map((x) => x.toPrecision(2));
  return `${low === high ? low : `${low}–${high}`} × (${values.length} volumes)`;
}

/** The claims of the paper beside the measured values, as a Markdown table. */
function claims(): string {
  const treeTimes = mediansOf("paradigms", /^time of \(B\), of marching cubes/);
  const cubesTimes = mediansOf("paradigms", /^time of \(B\), of vtkMarchingCubes/);
  const edgesTimes = mediansOf("paradigms", /^time of \(B\), of vtkFlyingEdges3D/);
  const memory = mediansOf("paradigms", /^peak memory of \(B\), of vtkMarchingCubes/);
  const quads = mediansOf("frame_rate", /^frames per mesh frame/, /quad$/);
  const closeUp = mediansOf("frame_rate", /^close-up: frames per mesh frame/, /exact$/);
  const holds = (isTrue: boolean) => (isTrue ? "yes" : "no");
  const rows = [
    ["the paper", "measured", "holds"],
    ["---", "---", "---"],
    [
      "extraction takes half the time of marching cubes with an interval tree",
      `time of (B): ${rangeText(treeTimes)}`,
      holds(Math.max(...treeTimes) <= 0.5),
    ],
    [
      "it needs less memory than marching cubes (here VTK's)",
      `peak memory of (B): ${rangeText(memory)}`,
      holds(Math.max(...memory) < 1),
    ],
    [
      "points are drawn at four times the frame rate of triangles",
      `frame rate of quads: ${rangeText(quads)}`,
      holds(Math.min(...quads) >= 4),
    ],
    ["(not in the paper) close up, exact splats", `frame rate: ${rangeText(closeUp)}`, ""],
    ["(not in the paper) VTK's marching cubes", `time of (B): ${rangeText(cubesTimes)}`, ""],
    ["(not in the paper) VTK's Flying Edges", `time of (B): ${rangeText(edgesTimes)}`, ""],
  ];
  return markdown(rows);
}

/** Columns of the tables of samplings: heading, measure, digits. */
const samplingColumns = [
  ["time, ×", "time, of centre samples with one step", 1],
  ["from points to the surface, mean", "from points to the surface, mean", 4],
  ["from the surface to points, 95 %", "from the surface to points, 95 %", 2],
  ["dropped samples, %", "dropped samples", 1],
  ["surface beyond half a diagonal, %", "surface beyond half a cell's diagonal from all points", 2],
] as const;

/** Errors of the paper's samplings and projections for a volume, as a Markdown table. */
function samplings(volume: string): string {
  const rows = readResults("sampling").filter((row) => row.case.startsWith(`${volume}, `));
  const ways = [...new Set(rows.map((row) => row.case.slice(volume.length + 2)))];
  const value = (way: string | undefined, measure: string) =>
    rows.find((row) => row.case === `${volume}, ${way}` && row.measure === measure)?.median ?? 0;
  const headings = ["samples per cell", ...samplingColumns.map(([heading]) => heading)];
  const line = (way: string) => [
    way,
    (value(way, "samples") / value(ways[0], "samples")).toFixed(1),
    ...samplingColumns.map(([, measure, digits]) => value(way, measure).toFixed(digits)),
  ];
  const table = [[volume, ...headings], headings.map(() => "---"), ...ways.map(line)];
  table[1]?.push("---");
  return markdown(table);
}

/** The steps from a file to a link, in their order. */
function steps(figures: Figures, way: string): string {
  const rows = readResults("first_use").filter((row) => row.case === way);
  const names = [...new Set(rows.map(({ measure, unit }) => `${measure}\n${unit}`))];
  const line = (name: string): string[] => {
    const [measure = "", unit = ""] = name.split("\n");
    return [measure, `${figures.of("first_use", [way], measure, unit)} ${unit}`];
  };
  return markdown([["step", "median"], ["---", "---"], ...names.map(line)]);
}

/** Growth with the number of voxels, and the plan that follows. */
function scaleTables(): DocumentTable[] {
  const file = "docs/scale.md";
  return [
    ...["turbulence", "fractal", "engine ×"].map((kind) => ({
      file,
      name: `growth of ${kind.replace(" ×", "")}`,
      table: growthTable(kind),
    })),
    { file, name: "volume", table: volumePlan() },
    { file, name: "checks", table: checks() },
    { file, name: "ranks: assumptions", table: rankAssumptions() },
    { file, name: "ranks: parts", table: rankPartsTable() },
    { file, name: "ranks: two", table: twoRanks() },
    { file, name: "ranks", table: ranksTable() },
    { file, name: "visits", table: visitsTable() },
    { file, name: "replays", table: replayTable() },
    { file, name: "assumptions", table: assumptions() },
    { file, name: "viewers", table: viewersPlan() },
    { file, name: "limits", table: limits() },
  ];
}

/** All tables in documents that are written from the results. */
export function documentTables(): DocumentTable[] {
  const bench = "docs/bench/README.md";
  const samplingTables = ["engine 60.5", "aneurysm 100.5"].map(samplings).join("\n\n");
  const figures = new Figures();
  const readme = [
    { file: "README.md", name: "figures of the network", table: networkFigures(figures) },
    { file: "README.md", name: "figures of the program", table: programFigures(figures) },
    { file: "README.md", name: "figures of the server", table: serverFigures(figures) },
    { file: "README.md", name: "figures of pictures", table: pictureFigures(figures) },
  ];
  return [
    ...readme,
    {
      file: "README.md",
      name: "machines of the figures",
      table: `${[...figures.machines].join("; ")}.`,
    },
    ...["browser alone", "with the program"].map((way) => ({
      file: "docs/first-use.md",
      name: way,
      table: steps(new Figures(), way),
    })),
    ...scaleTables(),
    { file: bench, name: "claims", table: claims() },
    { file: bench, name: "samplings", table: samplingTables },
    { file: bench, name: "ewa", table: ewaTable() },
    { file: bench, name: "peers", table: peerTables() },
  ];
}

/** A document with its table replaced. Throws if the document has no marks for it. */
export function withTable(text: string, { file, name, table }: DocumentTable): string {
  const marked = new RegExp(`(<!-- ${name} -->\\n\\n?)[\\s\\S]*?(<!-- end -->)`);
  if (!marked.test(text)) throw new Error(`${file}: expected <!-- ${name} --> and <!-- end -->`);
  return text.replace(marked, (_, begin, end) => `${begin}${table}\n${end}`);
}

/** Writes all tables into their documents. */
export function writeTables(): void {
  for (const table of documentTables()) {
    const path = join(root, table.file);
    writeFileSync(path, withTable(readFileSync(path, "utf8"), table));
  }
}
