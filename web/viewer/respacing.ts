import type { StoreInfo, Triple } from "../core/types.ts";
import type { Camera, ClipPlane } from "./types.ts";
import { cross, dot, plus, times } from "./vectors.ts";

/** Moves what lies in the world of a volume along with its voxels, when the distances between them change. */
export interface Respacing {
  point(position: Triple): Triple;
  plane(plane: ClipPlane): ClipPlane;
  /** The volume keeps its size in the picture, on average over its axes. */
  camera(camera: Camera): Camera;
}

/** From the grid of `info` to the same grid with the spacing `after`. Voxel (0, 0, 0) stays where it is. */
export function respacing(
  { origin, direction, spacing }: Pick<StoreInfo, "origin" | "direction" | "spacing">,
  after: Triple,
): Respacing {
  const axes = [0, 1, 2].map((axis) =>
    [0, 1, 2].map((row) => direction[3 * row + axis] ?? 0),
  ) as unknown as [Triple, Triple, Triple];
  const factors = after.map((length, axis) => length / (spacing[axis] ?? 1));
  const factor = (axis: number): number => factors[axis] ?? 1;
  const [x, y, z] = axes;
  const volume = dot(x, cross(y, z));
  const duals = [cross(y, z), cross(z, x), cross(x, y)].map((dual) => times(dual, 1 / volume));
  const sum = (vectors: readonly Triple[]): Triple => vectors.reduce(plus, [0, 0, 0]);
  const moved = (v: Triple): Triple =>
    sum(axes.map((axis, i) => times(axis, factor(i) * dot(duals[i] ?? axis, v))));
  const point = (position: Triple): Triple =>
    plus(origin, moved(plus(position, times(origin, -1))));
  return {
    point,
    plane: ({ normal, offset }) => {
      const turned = sum(
        duals.map((dual, i) => times(dual, dot(axes[i] ?? dual, normal) / factor(i))),
      );
      const length = Math.hypot(...turned);
      const at = dot(turned, origin) + offset - dot(normal, origin);
      return { normal: times(turned, 1 / length), offset: at / length };
    },
    camera: (camera) => ({
      ...camera,
      target: point(camera.target),
      distance: camera.distance * Math.cbrt(factor(0) * factor(1) * factor(2)),
    }),
  };
}
