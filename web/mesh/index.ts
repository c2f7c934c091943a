/**
 * Triangles of isosurfaces. The module is loaded at its first use.
 *
 *     const { file, triangles } = await saveSurface(source, 60.5, { format: "stl", signal, progress });
 */
export type { SurfaceForecast } from "./forecast.ts";
export type { JobOptions } from "./run_job.ts";
export {
  forecastSurface,
  type SavedSurface,
  type SaveSurfaceOptions,
  type SurfaceOptions,
  saveSurface,
} from "./save_surface.ts";
export { type SurfaceExtent, surfaceExtent } from "./surface_extent.ts";
export { SurfaceReader } from "./surface_reader.ts";
export { type GridBox, type HalfSpace, type MeshFormat, meshFormats } from "./types.ts";
