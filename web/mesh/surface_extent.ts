import { type JobOptions, runJob } from "./run_job.ts";
import type { SurfaceReader } from "./surface_reader.ts";

export interface SurfaceExtent {
  /** World units². */
  area: number;
  /**
   * Volume of the region with values above the isovalue, world units³; undefined if the volume has
   * missing voxels.
   */
  volumeAbove?: number;
  /** Volume of the whole grid, world units³. */
  gridVolume: number;
}

/**
 * Area and volume of an isosurface, from its triangles at full detail (shared/core/mesh/surface_extent.h).
 * Works in pieces of one chunk. Rejects with a StreamError, a CoreError, or the signal's reason.
 */
export async function surfaceExtent(
  reader: SurfaceReader,
  isovalue: number,
  options: JobOptions = {},
): Promise<SurfaceExtent> {
  const { info } = reader;
  const signal = options.signal ?? new AbortController().signal;
  const chunks = await reader.chunksOf(isovalue, 0, signal);
  const quantizedIsovalue = reader.quantizedIsovalue(isovalue);
  const { numbers } = await runJob(
    reader,
    chunks,
    { kind: "extent", info, quantizedIsovalue },
    options,
  );
  const [area, volumeAbove, gridVolume] = numbers;
  return { area, gridVolume, ...(!info.mapping.hasMissing && { volumeAbove }) };
}
