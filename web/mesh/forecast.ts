import { activeCellsAt } from "../core/active_cells.ts";
import type { Chunk } from "../core/records.ts";
import type { StoreInfo } from "../core/types.ts";
import type { MeshFormat } from "./types.ts";

/** The cost of a file of a surface, before it is created. */
export interface SurfaceForecast {
  /** Of chunks. */
  bytesToFetch: number;
  /** Approximate; at coarse levels, and in a box, an approximate upper bound. */
  triangles: number;
  fileBytes: number;
  /** Time to compute the triangles, without fetching. */
  seconds: number;
  /** Why the file cannot be created, and a remedy; undefined if it can. */
  problem?: string;
}

/**
 * Cells of chunks per second, without fetching. Measured: 1.4 to 3.5 million per second of
 * processor time (engine 60.5 and bonsai 40.5 as STL and GLB, in Node on one core of a server).
 */
const cellsPerSecond = 2e6;
/** Maximum memory of the module, below its limit of 2 GiB. */
const mostMemory = 1.7e9;
/** Memory for the mesh of a cell, while its layer of blocks is in memory. */
const memoryPerCell = 100;
/** Memory for the mesh of a cell of a closed surface, which is in memory as a whole. */
const memoryPerClosedCell = 150;
/** GLB files have 32-bit lengths; larger files of other formats would fill the device. */
const mostFileBytes = 2 ** 32 - 1;
/** Header bytes, and bytes of a vertex and of a triangle. */
const sizes = {
  stl: { header: 84, vertex: 0, triangle: 50 },
  ply: { header: 300, vertex: 24, triangle: 13 },
  glb: { header: 4124, vertex: 24, triangle: 12 },
} as const;

/**
 * `chunks`: all chunks that are needed, ascending by z. A surface has about one vertex for each
 * cell.
 */
export function forecastOf(
  info: StoreInfo,
  isovalue: number,
  {
    level,
    format,
    closed,
    hasBox,
  }: { level: number; format: MeshFormat; closed: boolean; hasBox: boolean },
  chunks: readonly Chunk[],
): SurfaceForecast {
  const layers = new Map<number, number>();
  let bytesToFetch = 0;
  let inChunks = 0;
  for (const { bytes, cells, block } of chunks) {
    bytesToFetch += bytes;
    inChunks += cells;
    layers.set(block[2], (layers.get(block[2]) ?? 0) + cells);
  }
  const active = level === 0 && !hasBox ? activeCellsAt(info, isovalue) : undefined;
  const cells = Math.min(inChunks, active ?? inChunks);
  const { header, vertex, triangle } = sizes[format];
  const fileBytes = header + cells * (vertex + 2 * triangle);
  const two = Math.max(0, ...[...layers].map(([z, count]) => count + (layers.get(z + 1) ?? 0)));
  const whole = closed ? memoryPerClosedCell * cells : 0;
  const memory = two * memoryPerCell + whole + (format === "stl" ? 24 * cells : 0);
  const found = memory > mostMemory || fileBytes > mostFileBytes;
  return {
    bytesToFetch,
    triangles: 2 * cells,
    fileBytes,
    seconds: inChunks / cellsPerSecond,
    ...(found && {
      problem:
        "expected a surface that fits into the browser's memory and into 4 GB, found about " +
        `${Math.round(cells / 1e6)} million cells: choose a coarser level, clip the volume, or use ` +
        "isosplat extract --mesh",
    }),
  };
}
