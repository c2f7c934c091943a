import type { Pick } from "../../build/wasm/web/layouts.js";
import type { LayerList } from "./layer_list.ts";
import type { RendererLife } from "./renderer_life.ts";
import type { Camera, SurfacePoint } from "./types.ts";

/**
 * Viewer.pick. Undefined without a picture: no layer is open, the context is lost, or the canvas has no
 * size.
 */
export function pickedPoint(
  life: RendererLife,
  layers: LayerList,
  { clientWidth: width, clientHeight: height }: HTMLCanvasElement,
  camera: Camera,
  x: number,
  y: number,
): SurfacePoint | undefined {
  if (!layers.isOpen || life.isContextLost || width === 0) return undefined;
  let point: SurfacePoint | undefined;
  life.guard((renderer) => {
    renderer.picture.setCamera(camera);
    const pick = renderer.pick(x, y, width, height);
    if (pick) point = surfacePointOf(pick, layers);
  });
  return point;
}

/** Converts the renderer's result for a position in the picture. */
function surfacePointOf(pick: Pick, layers: LayerList): SurfacePoint {
  const { position, voxel, normal, gradient, toNext, value, level, face, volume, hasField } = pick;
  const point: SurfacePoint = {
    position,
    voxel,
    normal,
    gradient,
    isovalue: value,
    level,
    layer: layers.idOf(volume),
  };
  if (toNext > 0) point.toNext = toNext;
  if (hasField === 1) point.field = pick.field;
  if (face === 1) point.cap = true;
  if (face === 2) point.slice = true;
  return point;
}
