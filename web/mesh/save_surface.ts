import { CoreError } from "../core/calls.ts";
import type { Chunk } from "../core/records.ts";
import type { Source } from "../stream/source.ts";
import { forecastOf, type SurfaceForecast } from "./forecast.ts";
import { type JobOptions, runJob } from "./run_job.ts";
import { SurfaceReader } from "./surface_reader.ts";
import type { GridBox, HalfSpace, MeshFormat } from "./types.ts";

export interface SurfaceOptions {
  /**
   * Default: "glb". STL has no shared vertices, no normals of vertices, and no unit: it has the
   * volume's own, millimetres.
   */
  format?: MeshFormat;
  /** 0 (the default) is the finest; each further level halves each axis. */
  level?: number;
  /**
   * Only what is in this box, in fractions of the volume: `clip` of a viewer. Of an open surface:
   * only cells whose centres are in it.
   */
  box?: GridBox;
  /**
   * Closes the surface around the solid, where values are above the isovalue: at the volume's border,
   * and where `box` and `planes` cut it. If missing voxels leave holes, or lost details of coarser
   * levels do, true and planes reject with invalid_argument. Default: true for STL at level 0, but a
   * surface with holes stays open.
   */
  closed?: boolean;
  /** Only what is in these half-spaces: `clip.planes` of a viewer. Only of closed surfaces. */
  planes?: readonly HalfSpace[];
  /** Ends the work; it then rejects with the signal's reason. */
  signal?: AbortSignal;
}

export interface SaveSurfaceOptions extends SurfaceOptions, JobOptions {
  /** A line for the file's header. Default: isovalue, volume and level. */
  comment?: string;
}

export interface SavedSurface {
  file: Blob;
  vertices: number;
  triangles: number;
  /** Whether the surface was closed. */
  closed: boolean;
}

/** The cost of saving a surface. Fetches pages of the directory for this. */
export async function forecastSurface(
  from: Source | SurfaceReader,
  isovalue: number,
  options: SurfaceOptions = {},
): Promise<SurfaceForecast> {
  return withReader(from, options, async (reader) => (await plan(reader, isovalue, options))[1]);
}

/**
 * The isosurface of an isovalue as a file of triangles. The bytes equal those that `isosplat
 * extract --mesh` writes with the same comment. Fetches all chunks that the isovalue needs, and
 * computes the triangles in a worker (in Node, on the calling thread), layer by layer. Rejects with
 * a StreamError, a CoreError (not_found: no such level; out_of_memory: `SurfaceForecast.problem`),
 * or the signal's reason.
 */
export async function saveSurface(
  from: Source | SurfaceReader,
  isovalue: number,
  options: SaveSurfaceOptions = {},
): Promise<SavedSurface> {
  return withReader(from, options, async (reader) => {
    const { closed, planes = [] } = options;
    try {
      return await save(reader, isovalue, options);
    } catch (error) {
      if (!hasHoles(error) || closed !== undefined || planes.length > 0 || !isClosed(options))
        throw error;
      return save(reader, isovalue, { ...options, closed: false });
    }
  });
}

async function save(
  reader: SurfaceReader,
  isovalue: number,
  options: SaveSurfaceOptions,
): Promise<SavedSurface> {
  const { format = "glb", level = 0, box, planes = [] } = options;
  const closed = isClosed(options);
  const [chunks, forecast] = await plan(reader, isovalue, options);
  if (forecast.problem) throw new CoreError("out_of_memory", forecast.problem);
  const { info } = reader;
  const name = info.metadata.name ?? "a volume";
  const { numbers, file } = await runJob(
    reader,
    chunks,
    {
      kind: "file",
      info,
      quantizedIsovalue: reader.quantizedIsovalue(isovalue),
      level,
      format,
      comment: options.comment ?? `isosurface ${isovalue} of ${name}, level ${level}, by isosplat`,
      ...(box && { box: { low: box.low, high: box.high } }),
      closed,
      planes: planes.map(({ normal, offset }) => ({ normal, offset })),
    },
    options,
  );
  const [vertices, triangles] = numbers;
  if (!file) throw new CoreError("internal", "the mesh has no file");
  return { file, vertices, triangles, closed };
}

/** Whether an error of saveSurface says that the surface cannot be closed, because it has holes. */
export function hasHoles(error: unknown): boolean {
  return (
    error instanceof CoreError &&
    error.status === "invalid_argument" &&
    error.message.includes("found holes") // shared/core/mesh/mesh_cap.cpp
  );
}

/** Whether these options ask for a closed surface. */
export function isClosed({
  format,
  level = 0,
  closed = format === "stl" && level === 0,
}: SurfaceOptions): boolean {
  return closed;
}

async function plan(
  reader: SurfaceReader,
  isovalue: number,
  options: SurfaceOptions,
): Promise<[Chunk[], SurfaceForecast]> {
  const { format = "glb", level = 0, box, planes = [] } = options;
  const { signal = new AbortController().signal } = options;
  const closed = isClosed(options);
  const { levels } = reader.info;
  if (planes.length > 0 && !closed) {
    throw new CoreError(
      "invalid_argument",
      "expected a closed surface, which planes can cut, found an open one: set closed to true",
    );
  }
  if (!(Number.isInteger(level) && level >= 0 && level < levels)) {
    throw new CoreError(
      "not_found",
      `expected a level from 0 to ${levels - 1}, found ${level}: choose another level`,
    );
  }
  const chunks = await reader.chunksOf(isovalue, level, signal, box);
  return [
    chunks,
    forecastOf(
      reader.info,
      isovalue,
      { level, format, closed, hasBox: box !== undefined || planes.length > 0 },
      chunks,
    ),
  ];
}

async function withReader<T>(
  from: Source | SurfaceReader,
  { signal = new AbortController().signal }: SurfaceOptions,
  use: (reader: SurfaceReader) => Promise<T>,
): Promise<T> {
  if (from instanceof SurfaceReader) return use(from);
  const reader = await SurfaceReader.open(from, signal);
  try {
    return await use(reader);
  } finally {
    reader.close();
  }
}
