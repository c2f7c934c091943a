import { type SavedSurface, type SaveSurfaceOptions, saveSurface } from "../mesh/save_surface.ts";
import { SurfaceReader } from "../mesh/surface_reader.ts";
import type { IsosplatViewerElement } from "./isosplat_viewer.ts";

/** IsosplatViewerElement.saveSurface. Rejects with an Error. */
export async function surfaceOf(
  { isovalues, source, viewer }: IsosplatViewerElement,
  options: SaveSurfaceOptions,
): Promise<SavedSurface> {
  const [isovalue] = isovalues;
  const access = viewer?.storeAccess;
  const from = access ? new SurfaceReader(access) : source;
  if (isovalue === undefined || !from) throw new Error("no volume is open");
  return saveSurface(from, isovalue, options);
}
