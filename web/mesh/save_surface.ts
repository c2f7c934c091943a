import { CoreError } from "../core/calls.ts";
import type { Chunk } from "../core/records.ts";
import type { Source } from "../stream/source.ts";
import { forecastOf, type SurfaceForecast } from "./forecast.ts";
import { type JobOptions, runJob } from "./run_job.ts";
import { SurfaceReader } from "./surface_reader.ts";
import type { GridBox, MeshFormat } from "./types.ts";

export interface SurfaceOptions {
  /** Default: "glb". STL has no shared vertices and no normals of vertices. */
  format?: MeshFormat;
  /** 0 (the default) is the finest; each further level halves each axis. */
  level?: number;
  /** Only cells whose centres are in this box, in fractions of the volume: `clip` of a viewer. */
  box?: GridBox;
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
    const { format = "glb", level = 0, box } = options;
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
        comment:
          options.comment ?? `isosurface ${isovalue} of ${name}, level ${level}, by isosplat`,
        ...(box && { box: { low: box.low, high: box.high } }),
      },
      options,
    );
    const [vertices, triangles] = numbers;
    if (!file) throw new CoreError("internal", "the mesh has no file");
    return { file, vertices, triangles };
  });
}

async function plan(
  reader: SurfaceReader,
  isovalue: number,
  { format = "glb", level = 0, box, signal = new AbortController().signal }: SurfaceOptions,
): Promise<[Chunk[], SurfaceForecast]> {
  const { levels } = reader.info;
  if (!(Number.isInteger(level) && level >= 0 && level < levels)) {
    throw new CoreError(
      "not_found",
      `expected a level from 0 to ${levels - 1}, found ${level}: choose another level`,
    );
  }
  const chunks = await reader.chunksOf(isovalue, level, signal, box);
  return [
    chunks,
    forecastOf(reader.info, isovalue, { level, format, hasBox: box !== undefined }, chunks),
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
