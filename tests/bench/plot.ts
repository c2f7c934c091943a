// npm run bench -- plot: draws the plots of docs/bench from the results, and writes the tables of its
// README, without measuring.
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { parse, View } from "vega";
import { type Config, compile, type TopLevelSpec } from "vega-lite";
import { root } from "./harness/paths.ts";
import { readResults } from "./harness/table.ts";

/** A plot, and the file that it is written to. */
interface Plot {
  file: string;
  spec: TopLevelSpec;
}

const small = { width: 200, height: 170 };
const config: Config = {
  background: "white",
  font: "sans-serif",
  view: { stroke: "#ccc" },
  legend: { labelLimit: 300 },
  axis: { labelLimit: 300 },
};

/** Names of methods in the order of the legend, "(B) as shipped" first. */
const methods = [
  "(B) as shipped",
  "(A) project at extraction",
  "(C) sample and project at extraction",
  "(D) sample at extraction",
  "marching cubes, interval tree",
  "vtkMarchingCubes",
  "vtkFlyingEdges3D",
];
const colour = (title: string | null, domain: string[]) =>
  ({ field: "method", type: "nominal", title, scale: { domain, scheme: "tableau10" } }) as const;

/** Rows whose case is "VOLUME, METHOD". */
function paradigmRows() {
  return readResults("paradigms").flatMap((row) => {
    const [, volume, method] = row.case.match(/^([^,]+), (.*)$/) ?? [];
    return volume && method ? [{ ...row, volume, method }] : [];
  });
}

/** The paper's figure 6: time of an extraction by the number of active cells. */
function extractionTimes(): Plot {
  const values = paradigmRows().flatMap((row) => {
    const active = Number(row.measure.match(/^(\d+) active cells/)?.[1] ?? 0);
    return active >= 1000 ? [{ ...row, active: active / 1000, ms: row.median }] : [];
  });
  return {
    file: "extraction.svg",
    spec: {
      config,
      title: "One extraction, one thread",
      data: { values },
      facet: { field: "volume", type: "nominal", title: null },
      columns: 3,
      resolve: { scale: { x: "independent", y: "independent" } },
      spec: {
        ...small,
        mark: { type: "line", point: { size: 18 } },
        encoding: {
          x: {
            field: "active",
            type: "quantitative",
            title: "thousand active cells",
            scale: { type: "log" },
          },
          y: { field: "ms", type: "quantitative", title: "ms", scale: { type: "log" } },
          color: colour(null, methods),
        },
      },
    },
  };
}

function peakMemory(): Plot {
  const values = paradigmRows().filter(({ measure }) => measure === "peak memory");
  return {
    file: "memory.svg",
    spec: {
      config,
      title: "Peak memory of the process during extractions",
      data: { values },
      facet: { field: "volume", type: "nominal", title: null },
      columns: 3,
      resolve: { scale: { x: "independent" } },
      spec: {
        width: 200,
        height: 120,
        mark: "bar",
        encoding: {
          x: { field: "median", type: "quantitative", title: "MB" },
          y: { field: "method", type: "nominal", title: null, sort: methods, axis: null },
          color: colour(null, methods),
        },
      },
    },
  };
}

function frameRates(): Plot {
  const values = readResults("frame_rate").flatMap((row) => {
    const [, volume, method] = row.case.match(/^(.*), (.*)$/) ?? [];
    return row.measure === "frames per mesh frame" ? [{ ...row, volume, method }] : [];
  });
  return {
    file: "frame_rate.svg",
    spec: {
      config,
      title: "Frames per second, relative to a Flying Edges mesh in the same renderer",
      data: { values },
      layer: [
        {
          ...small,
          width: 360,
          mark: "bar",
          encoding: {
            x: { field: "volume", type: "nominal", title: null, axis: { labelAngle: 0 } },
            xOffset: { field: "method", type: "nominal" },
            y: { field: "median", type: "quantitative", title: "× mesh" },
            color: colour("kind of splats", [...new Set(values.map(({ method }) => method ?? ""))]),
          },
        },
        { mark: { type: "rule", strokeDash: [4, 3] }, encoding: { y: { datum: 1 } } },
      ],
    },
  };
}

function firstImage(): Plot {
  const values = readResults("stream").flatMap((row) => {
    if (!/^first (surface|image), nothing cached$/.test(row.measure)) return [];
    const [, volume, link, peer] = row.case.match(/^([^,]+), ([^,]+, [^,]+)(, vtk.js)?$/) ?? [];
    const method = peer ? "vtk.js" : "Isosplat";
    return volume && link ? [{ ...row, volume: `${volume} (${method})`, link, method }] : [];
  });
  return {
    file: "first_image.svg",
    spec: {
      config,
      title: "From the visit until the first image, nothing cached",
      data: { values },
      facet: { field: "link", type: "nominal", title: null },
      spec: {
        width: 260,
        mark: "bar",
        encoding: {
          x: { field: "median", type: "quantitative", title: "s" },
          y: { field: "volume", type: "nominal", title: null },
          color: colour(null, ["Isosplat", "vtk.js"]),
        },
      },
    },
  };
}

function storeSizes(): Plot {
  const rows = readResults("store_size");
  const coarse = new Map(
    rows.filter((r) => r.measure === "coarse levels / raw").map((r) => [r.case, r.median]),
  );
  const values = rows
    .filter(({ measure }) => measure === "store / raw")
    .flatMap((row) => {
      const levels = coarse.get(row.case) ?? 0;
      return [
        { volume: row.case, method: "level 0", share: row.median - levels },
        { volume: row.case, method: "coarse levels", share: levels },
      ];
    });
  return {
    file: "store_size.svg",
    spec: {
      config,
      title: "Bytes of the store, relative to the bytes of the voxels",
      data: { values },
      width: 420,
      mark: "bar",
      encoding: {
        x: { field: "share", type: "quantitative", stack: true, title: "store / voxels" },
        y: { field: "volume", type: "nominal", title: null, sort: "-x" },
        color: colour(null, ["level 0", "coarse levels"]),
        order: { field: "method", sort: "descending" },
      },
    },
  };
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

/** The claims of the paper beside what was measured, as a Markdown table. */
function claims(): string {
  const treeTimes = mediansOf("paradigms", /^time of \(B\), of marching cubes/);
  const cubesTimes = mediansOf("paradigms", /^time of \(B\), of vtkMarchingCubes/);
  const edgesTimes = mediansOf("paradigms", /^time of \(B\), of vtkFlyingEdges3D/);
  const memory = mediansOf("paradigms", /^peak memory of \(B\), of vtkMarchingCubes/);
  const quads = mediansOf("frame_rate", /^frames per mesh frame/, /quad$/);
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
    ["(not in the paper) VTK's marching cubes", `time of (B): ${rangeText(cubesTimes)}`, ""],
    ["(not in the paper) VTK's Flying Edges", `time of (B): ${rangeText(edgesTimes)}`, ""],
  ];
  return rows.map((row) => `| ${row.join(" | ")} |`).join("\n");
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
  return table.map((row) => `| ${row.join(" | ")} |`).join("\n");
}

/** Writes a table into the README of docs/bench, between <!-- NAME --> and <!-- end -->. */
function writeTable(name: string, table: string): void {
  const path = join(root, "docs/bench/README.md");
  const text = readFileSync(path, "utf8");
  const marked = new RegExp(`(<!-- ${name} -->\\n)[\\s\\S]*?(<!-- end -->)`);
  if (!marked.test(text)) throw new Error(`${path}: expected <!-- ${name} --> and <!-- end -->`);
  writeFileSync(
    path,
    text.replace(marked, (_, begin, end) => `${begin}${table}\n${end}`),
  );
}

/** Draws all plots and writes the tables. Returns the files, relative to the project. */
export async function drawPlots(): Promise<string[]> {
  const plots = [extractionTimes(), peakMemory(), frameRates(), firstImage(), storeSizes()];
  const folder = "docs/bench";
  for (const { file, spec } of plots) {
    const svg = await new View(parse(compile(spec).spec), { renderer: "none" }).toSVG();
    writeFileSync(join(root, folder, file), `${svg}\n`);
  }
  writeTable("claims", claims());
  writeTable("samplings", [samplings("engine 60.5"), samplings("aneurysm 100.5")].join("\n\n"));
  return plots.map(({ file }) => `${folder}/${file}`);
}
