import type { Camera, PictureSize } from "./types.ts";

/** A view along an axis of the world. */
export interface AxisView {
  /** The axis that points towards the eye: 0, 1, 2. */
  axis: 0 | 1 | 2;
  /** Whether the eye is on its positive or negative side. */
  side: 1 | -1;
  azimuth: number;
  elevation: number;
}

/** Front, back, left, right, above, below, in the angles of Camera. */
export const axisViews: readonly AxisView[] = [
  { axis: 1, side: -1, azimuth: 0, elevation: 0 },
  { axis: 1, side: 1, azimuth: 180, elevation: 0 },
  { axis: 0, side: 1, azimuth: 90, elevation: 0 },
  { axis: 0, side: -1, azimuth: -90, elevation: 0 },
  { axis: 2, side: 1, azimuth: 0, elevation: 90 },
  { axis: 2, side: -1, azimuth: 0, elevation: -90 },
];

/** The camera at the same distance, looking along an axis. */
export function cameraAlong(camera: Camera, { azimuth, elevation }: AxisView): Camera {
  return { ...camera, azimuth, elevation, roll: 0 };
}

/** The angle equal to `angle` modulo full turns that is at most half a turn away from `from`. */
function nearest(angle: number, from: number): number {
  return from + (((((angle - from) % 360) + 540) % 360) - 180);
}

/** A camera between two: share 0 is `from`, 1 is `to`. Angles take the shorter way. */
export function cameraBetween(from: Camera, to: Camera, share: number): Camera {
  if (share >= 1) return to;
  const mix = (a: number, b: number) => a + share * (b - a);
  return {
    target: [
      mix(from.target[0], to.target[0]),
      mix(from.target[1], to.target[1]),
      mix(from.target[2], to.target[2]),
    ],
    // Equal steps of time scale the visible size by equal factors.
    distance: from.distance * (to.distance / from.distance) ** share,
    azimuth: mix(from.azimuth, nearest(to.azimuth, from.azimuth)),
    elevation: mix(from.elevation, to.elevation),
    roll: mix(from.roll, nearest(to.roll, from.roll)),
    fieldOfView: mix(from.fieldOfView, to.fieldOfView),
    ...(to.projection && { projection: to.projection }),
  };
}

/** A camera that shows the whole view of a picture in a canvas of this aspect (width / height). */
export function cameraOfPicture(
  camera: Camera,
  { width, height }: PictureSize,
  aspect: number,
): Camera {
  const wider = Math.max(1, width / height / aspect);
  const half = Math.atan(wider * Math.tan((camera.fieldOfView * Math.PI) / 360));
  return { ...camera, fieldOfView: Math.min((half * 360) / Math.PI, 120) };
}
