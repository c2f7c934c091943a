import { activeCellsAt } from "../core/active_cells.ts";
import type { Chunk } from "../core/records.ts";
import type { StoreInfo } from "../core/types.ts";
import type { MeshFormat } from "./types.ts";

/** What a file of a surface costs, before it is made. */
export interface SurfaceForecast {
  /** Of chunks. */
  bytesToFetch: number;
  /** About so many; at coarse levels, and in a box, at most about so many. */
  triangles: number;
  fileBytes: number;
  /** To make the triangles, without the time to fetch. */
  seconds: number;
  /** Why it cannot be made, and what to do; undefined if it can. */
  problem?: string;
}

/**
 * Cells of chunks, fetching excluded. Measured: 1.4 to 3.5 million a second of processor time (engine
 * 60.5 and bonsai 40.5 as STL and GLB, in Node on one core of a server).
 */
const cellsPerSecond = 2e6;
/** Most memory of the module, below the 2 GiB that it may have. */
const mostMemory = 1.7e9;
/** Of the mesh of a cell, while its layer of blocks is in memory. */
const memoryPerCell = 100;
/** GLB files have 32-bit lengths; files of other formats that are larger fill the device. */
const mostFileBytes = 2 ** 32 - 1;
/** Header bytes, and bytes of a vertex and of a triangle. */
const sizes = {
  stl: { header: 84, vertex: 0, triangle: 50 },
  ply: { header: 300, vertex: 24, triangle: 13 },
  glb: { header: 4124, vertex: 24, triangle: 12 },
} as const;

/** `chunks`: all that are needed, ascending by z. A surface has about one vertex for each cell. */
export function forecastOf(
  info: StoreInfo,
  isovalue: number,
  { level, format, hasBox }: { level: number; format: MeshFormat; hasBox: boolean },
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
  const memory = two * memoryPerCell + (format === "stl" ? 24 * cells : 0);
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
