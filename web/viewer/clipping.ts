import * as layouts from "../../build/wasm/web/layouts.js";
import type { StoreInfo, Triple } from "../core/types.ts";
import type { Camera, Clip, ClipPlane } from "./types.ts";

/** The largest number of planes besides the box (kMaxClipPlanes in shared/render/settings/render_settings.h). */
export const maxClipPlanes: number = layouts.maxClipPlanes;

export const wholeVolume: Clip = { low: [0, 0, 0], high: [1, 1, 1], planes: [] };

/** Whether nothing is cut away. */
export function isWhole({ low, high, planes }: Clip): boolean {
  return low.every((v) => v === 0) && high.every((v) => v === 1) && planes.length === 0;
}

export function isDefaultClip(clip: Clip): boolean {
  return isWhole(clip) && !clip.caps;
}

/** The smallest and the largest value of normal · world in the volume. */
export function extentAlong(normal: Triple, info: StoreInfo): [number, number] {
  const { origin, direction, spacing, voxels } = info;
  let low = 0;
  let high = 0;
  for (let axis = 0; axis < 3; ++axis) {
    const length = (spacing[axis] ?? 0) * ((voxels[axis] ?? 1) - 1);
    let along = 0;
    for (let row = 0; row < 3; ++row)
      along += (normal[row] ?? 0) * (direction[3 * row + axis] ?? 0);
    low += Math.min(0, along * length);
    high += Math.max(0, along * length);
  }
  const start = normal.reduce((sum, n, i) => sum + n * (origin[i] ?? 0), 0);
  return [start + low, start + high];
}

/** A plane through the centre of the volume that cuts away the half towards the eye. */
export function planeFacing(camera: Camera, info: StoreInfo): ClipPlane {
  const azimuth = (camera.azimuth * Math.PI) / 180;
  const elevation = (camera.elevation * Math.PI) / 180;
  // The viewing direction, as in camera_frame of shared/render/settings/camera.cpp.
  const normal: Triple = [
    -Math.sin(azimuth) * Math.cos(elevation),
    Math.cos(azimuth) * Math.cos(elevation),
    -Math.sin(elevation),
  ];
  const [low, high] = extentAlong(normal, info);
  return { normal, offset: (low + high) / 2 };
}
