/**
 * The perspective camera of a scripted visitor. Gestures change it as in
 * shared/render/settings/camera.h.
 */
import type { StoreInfo, Triple } from "../../../web/core/index.ts";

const degree = Math.PI / 180;
const tanHalfField = Math.tan(15 * degree);

const dot = (a: Triple, b: Triple) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
/** a + factor · b */
const plus = (a: Triple, b: Triple, factor = 1): Triple => [
  a[0] + factor * b[0],
  a[1] + factor * b[1],
  a[2] + factor * b[2],
];

/** The world position of a point of the volume, 0 … 1 along each axis. */
function world({ voxels, spacing, origin, direction }: StoreInfo, place: Triple): Triple {
  const along = place.map((share, i) => share * ((voxels[i] ?? 1) - 1) * (spacing[i] ?? 1));
  return [0, 1, 2].map(
    (row) =>
      (origin[row] ?? 0) +
      along.reduce((sum, length, column) => sum + length * (direction[3 * row + column] ?? 0), 0),
  ) as Triple;
}

export class VisitorCamera {
  readonly #centre: Triple;
  readonly #radius: number;
  #target: Triple;
  #distance = 0;
  #azimuth = 30;
  #elevation = 20;

  /** The first camera of a volume: all of it is in the picture. `aspect`: width / height. */
  constructor(info: StoreInfo, aspect: number) {
    this.#centre = world(info, [0.5, 0.5, 0.5]);
    this.#target = this.#centre;
    const { right, up, forward } = this.#axes();
    this.#radius = 0;
    for (let i = 0; i < 8; ++i) {
      const corner = plus(world(info, [i & 1, (i >> 1) & 1, i >> 2]), this.#centre, -1);
      const aside = Math.max(Math.abs(dot(corner, right)) / aspect, Math.abs(dot(corner, up)));
      this.#distance = Math.max(this.#distance, aside / tanHalfField - dot(corner, forward));
      this.#radius = Math.max(this.#radius, Math.sqrt(dot(corner, corner)));
    }
    this.#distance *= 1.04;
  }

  #axes(): { right: Triple; up: Triple; forward: Triple } {
    const [azimuth, elevation] = [this.#azimuth * degree, this.#elevation * degree];
    const [sin, cos] = [Math.sin(azimuth), Math.cos(azimuth)];
    const [rise, level] = [Math.sin(elevation), Math.cos(elevation)];
    return {
      right: [cos, sin, 0],
      up: [-sin * rise, cos * rise, level],
      forward: [-sin * level, cos * level, -rise],
    };
  }

  orbit(rightDegrees: number, upDegrees: number): void {
    this.#azimuth -= rightDegrees;
    this.#elevation = Math.max(-90, Math.min(90, this.#elevation + upDegrees));
  }

  zoom(factor: number): void {
    this.#distance *= factor;
  }

  /** Shifts the picture. The unit is its height. */
  pan(right: number, down: number): void {
    const height = 2 * this.#distance * tanHalfField;
    const axes = this.#axes();
    this.#target = plus(plus(this.#target, axes.right, -right * height), axes.up, down * height);
  }

  /** Columns of projection · view: world to clip space. */
  viewProjection(width: number, height: number): number[] {
    const { right, up, forward } = this.#axes();
    const eye = plus(this.#target, forward, -this.#distance);
    const depth = dot(plus(this.#centre, eye, -1), forward);
    const far = Math.max(depth + 1.01 * this.#radius, 1e-2 * this.#radius);
    const near = Math.max(depth - 1.01 * this.#radius, 5e-4 * far);
    const a = (far + near) / (far - near);
    const b = (-2 * far * near) / (far - near);
    const sy = 1 / tanHalfField;
    const sx = (sy * height) / width;
    const column = (i: 0 | 1 | 2) => [sx * right[i], sy * up[i], a * forward[i], forward[i]];
    return [
      ...[...column(0), ...column(1), ...column(2)],
      ...[-sx * dot(right, eye), -sy * dot(up, eye), b - a * dot(forward, eye), -dot(forward, eye)],
    ];
  }
}
