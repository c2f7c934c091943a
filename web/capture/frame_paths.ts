import { cameraBetween } from "../viewer/camera_views.ts";
import type { Camera, Surface } from "../viewer/types.ts";

/** The content of a frame of a film. */
export interface FrameView {
  camera: Camera;
  surfaces: readonly Surface[];
  /** The step of `Viewer.time`. Default: the one that is shown. */
  step?: number;
}

/** One turn around the axis of the azimuth. The frame after the last would equal the first. */
export function turntable(view: FrameView, frames: number): FrameView[] {
  return Array.from({ length: frames }, (_, frame) => ({
    ...view,
    camera: { ...view.camera, azimuth: view.camera.azimuth + (360 * frame) / frames },
  }));
}

/** One surface passes through its isovalues in equal steps. */
export function sweep(
  view: FrameView,
  surface: number,
  [from, to]: readonly [number, number],
  frames: number,
): FrameView[] {
  return Array.from({ length: frames }, (_, frame) => {
    const isovalue = from + (to - from) * shareOf(frame, frames);
    const surfaces = view.surfaces.map((each, i) => (i === surface ? { ...each, isovalue } : each));
    return { ...view, surfaces };
  });
}

/** Shows all steps of a scene that changes with time, each for the same duration. */
export function throughTime(view: FrameView, steps: number, frames: number): FrameView[] {
  return Array.from({ length: frames }, (_, frame) => ({
    ...view,
    step: Math.min(steps - 1, Math.floor((frame * steps) / frames)),
  }));
}

/** Moves from camera to camera. Each section takes the same time, and is slow at its ends. */
export function cameraPath(
  cameras: readonly Camera[],
  view: FrameView,
  frames: number,
): FrameView[] {
  const segments = cameras.length - 1;
  return Array.from({ length: frames }, (_, frame) => {
    const at = shareOf(frame, frames) * segments;
    const segment = Math.min(Math.floor(at), segments - 1);
    const [from, to] = [cameras[segment], cameras[segment + 1]];
    const share = at - segment;
    const camera =
      from && to ? cameraBetween(from, to, share * share * (3 - 2 * share)) : view.camera;
    return { ...view, camera };
  });
}

/** 0 for the first frame, 1 for the last. */
function shareOf(frame: number, frames: number): number {
  return frames > 1 ? frame / (frames - 1) : 0;
}
