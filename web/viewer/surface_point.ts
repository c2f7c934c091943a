import type { Pick } from "../../build/wasm/web/layouts.js";
import type { SurfacePoint } from "./types.ts";

/** Converts the renderer's result for a position in the picture. */
export function surfacePointOf(pick: Pick): SurfacePoint {
  const { position, voxel, normal, gradient, toNext, value, level, face, volume } = pick;
  const point: SurfacePoint = {
    position,
    voxel,
    normal,
    gradient,
    isovalue: value,
    level,
    layer: volume,
  };
  if (toNext > 0) point.toNext = toNext;
  if (face === 1) point.cap = true;
  if (face === 2) point.slice = true;
  return point;
}
