import { writeFileSync } from "node:fs";
import { join } from "node:path";
import { parse, View } from "vega";
import { type Config, compile, type TopLevelSpec } from "vega-lite";
import { root } from "../harness/paths.ts";
import { readResults } from "../harness/table.ts";
import { measures, Series } from "./growth.ts";
import { figureOf, viewerRuns } from "./viewers.ts";

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

/** Figures by the number of voxels, both on logarithmic axes, relative to the smallest volume. */
function growth(): Plot {
  const shown = [
    measures.build,
    measures.store,
    measures.active,
    measures.bytes,
    measures.small,
    measures.first,
  ];
  const values = ["turbulence", "fractal", "engine ×"].flatMap((kind) => {
    const series = new Series(kind);
    return shown.flatMap((measure) => {
      const points = series.points(measure);
      const [first] = points;
      return points.map(({ voxels, figure }) => ({
        volume: kind.replace(" ×", ""),
        method: measure.name,
        voxels: voxels / 1e6,
        times: figure / (first?.figure ?? figure),
      }));
    });
  });
  return {
    file: "growth.svg",
    spec: {
      config,
      title: "Growth with the number of voxels, relative to the smallest volume",
      data: { values },
      facet: { field: "volume", type: "nominal", title: null },
      columns: 3,
      spec: {
        ...small,
        mark: { type: "line", point: { size: 18 } },
        encoding: {
          x: {
            field: "voxels",
            type: "quantitative",
            title: "million voxels",
            scale: { type: "log" },
          },
          y: { field: "times", type: "quantitative", title: "×", scale: { type: "log" } },
          color: colour(
            null,
            shown.map(({ name }) => name),
          ),
        },
      },
    },
  };
}

/** The hits of caches of all sizes: calculated, and of nginx. */
function cacheSizes(): Plot {
  const kinds = ["requests", "bytes"];
  const points = viewerRuns().flatMap((run) => {
    const [, percent] = /^cache of ([\d.]+) % of the stores$/.exec(run.cache) ?? [];
    if (!percent) return [];
    return kinds.map((kind) => ({
      method: `of ${kind}`,
      size: Number(percent),
      hits: figureOf(run, `hits, of ${kind}`, "%") ?? Number.NaN,
      isCalculated: run.isCalculated,
    }));
  });
  const encoding = {
    x: {
      field: "size",
      type: "quantitative",
      title: "size of the cache, % of the stores",
      scale: { type: "log" },
    },
    y: {
      field: "hits",
      type: "quantitative",
      title: "hits, %",
      scale: { domainMin: 0, domainMax: 100 },
    },
    color: colour(
      null,
      kinds.map((kind) => `of ${kind}`),
    ),
  } as const;
  return {
    file: "cache_sizes.svg",
    spec: {
      config,
      title: "Hits of one cache for 10,000 viewers: lines calculated (LRU), points by nginx",
      width: 360,
      height: 200,
      layer: [
        {
          data: { values: points.filter(({ isCalculated }) => isCalculated) },
          mark: { type: "line", point: { size: 12 } },
          encoding,
        },
        {
          data: { values: points.filter(({ isCalculated }) => !isCalculated) },
          mark: { type: "point", size: 90, filled: false },
          encoding,
        },
      ],
    },
  };
}

/** Draws all plots into docs/bench. Returns the files, relative to the project. */
export async function drawPlots(): Promise<string[]> {
  const plots = [
    extractionTimes(),
    peakMemory(),
    frameRates(),
    firstImage(),
    storeSizes(),
    growth(),
    cacheSizes(),
  ];
  const folder = "docs/bench";
  for (const { file, spec } of plots) {
    const svg = await new View(parse(compile(spec).spec), { renderer: "none" }).toSVG();
    writeFileSync(join(root, folder, file), `${svg}\n`);
  }
  return plots.map(({ file }) => `${folder}/${file}`);
}
