import type { StoreInfo, Triple } from "../core/types.ts";
import { ticks } from "./lengths.ts";
import type { Screen, ScreenPoint } from "./screen.ts";

export interface Edge {
  from: ScreenPoint;
  to: ScreenPoint;
  /** Whether it ends at the corner farthest from the eye, so that the volume is in front of it. */
  isBehind: boolean;
}

export interface Tick {
  at: ScreenPoint;
  /** mm from the volume's first voxel, along the edge. */
  length: number;
  /** The direction away from the box, in pixels. */
  outwards: { x: number; y: number };
}

export interface BoxOnScreen {
  edges: Edge[];
  ticks: Tick[];
}

const cornerNumbers = [0, 1, 2, 3, 4, 5, 6, 7] as const;

/** A point of the volume: shares of the extents along the axes. */
export function positionAt(info: StoreInfo, shares: Triple): Triple {
  const { origin, direction, spacing, voxels } = info;
  const along = shares.map((s, axis) => s * ((voxels[axis] ?? 1) - 1) * (spacing[axis] ?? 1));
  const coordinate = (row: number) =>
    (origin[row] ?? 0) +
    along.reduce((sum, length, axis) => sum + length * (direction[3 * row + axis] ?? 0), 0);
  return [coordinate(0), coordinate(1), coordinate(2)];
}

const sharesOf = (corner: number): Triple => [corner & 1, (corner >> 1) & 1, (corner >> 2) & 1];

/**
 * The twelve edges of the volume and ticks on three of them; undefined if a corner is not in front
 * of the eye.
 */
export function boundingBox(info: StoreInfo, screen: Screen): BoxOnScreen | undefined {
  const corners = cornerNumbers.map((corner) => screen.point(positionAt(info, sharesOf(corner))));
  if (!corners.every((corner) => corner !== undefined)) return undefined;
  const depths = corners.map(({ depth }) => depth);
  const farthest = depths.indexOf(Math.max(...depths));
  const centre = {
    x: corners.reduce((sum, { x }) => sum + x / 8, 0),
    y: corners.reduce((sum, { y }) => sum + y / 8, 0),
  };
  const box: BoxOnScreen = { edges: [], ticks: [] };
  for (let axis = 0; axis < 3; ++axis) {
    const starts = cornerNumbers.filter((corner) => (corner & (1 << axis)) === 0);
    const edges = starts.map((start) => {
      const end = start | (1 << axis);
      const isBehind = start === farthest || end === farthest;
      return { start, isBehind, from: corners[start], to: corners[end] };
    });
    let labelled: { start: number; from: ScreenPoint; to: ScreenPoint } | undefined;
    let mostAway = 0;
    for (const { start, isBehind, from, to } of edges) {
      if (!from || !to) continue;
      box.edges.push({ from, to, isBehind });
      // The edge that is farthest from the middle of the box has free space beside it.
      const away = Math.hypot((from.x + to.x) / 2 - centre.x, (from.y + to.y) / 2 - centre.y);
      if (!isBehind && away > mostAway) {
        mostAway = away;
        labelled = { start, from, to };
      }
    }
    if (labelled) box.ticks.push(...ticksOf(info, screen, axis, labelled, centre));
  }
  return box;
}

function ticksOf(
  info: StoreInfo,
  screen: Screen,
  axis: number,
  { start, from, to }: { start: number; from: ScreenPoint; to: ScreenPoint },
  centre: { x: number; y: number },
): Tick[] {
  const extent = ((info.voxels[axis] ?? 1) - 1) * (info.spacing[axis] ?? 1);
  const pixels = Math.hypot(to.x - from.x, to.y - from.y);
  const count = Math.min(10, Math.floor(pixels / 45));
  if (count < 1 || extent <= 0) return [];
  // Across the edge, away from the middle of the box.
  let [x, y] = [(to.y - from.y) / pixels, (from.x - to.x) / pixels];
  const middle = { x: (from.x + to.x) / 2 - centre.x, y: (from.y + to.y) / 2 - centre.y };
  if (x * middle.x + y * middle.y < 0) [x, y] = [-x, -y];
  return ticks(0, extent, count).flatMap((length) => {
    const shares = sharesOf(start);
    shares[axis] = length / extent;
    const at = screen.point(positionAt(info, shares));
    return at ? [{ at, length, outwards: { x, y } }] : [];
  });
}
