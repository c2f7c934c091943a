import type { StoreInfo, Triple } from "../core/types.ts";
import type { Clip } from "../viewer/types.ts";
import { positionAt } from "./bounding_box.ts";
import type { Screen, ScreenPoint } from "./screen.ts";

/** A face of the clip box: across a grid axis, at the low or the high end of the box. */
export interface ClipFace {
  axis: 0 | 1 | 2;
  end: "low" | "high";
}

export const clipFaces: readonly ClipFace[] = ([0, 1, 2] as const).flatMap((axis) => [
  { axis, end: "low" as const },
  { axis, end: "high" as const },
]);

/** The smallest thickness of the box. An empty box would show nothing, just like an empty surface. */
export const leastThickness = 0.01;
/** The accuracy of a drag. Keys move by whole steps of the sliders in the panel. */
const dragStep = 0.001;
/**
 * A drag of this many pixels moves a face at most across the whole volume. This limits drags along axes
 * seen end on.
 */
const leastPixels = 80;

export function shareOf(clip: Clip, { axis, end }: ClipFace): number {
  return clip[end][axis];
}

/** The clip with a face moved to another position, as far as the opposite face allows. */
export function movedFace(clip: Clip, { axis, end }: ClipFace, share: number): Clip {
  const round = (value: number) => Number(value.toFixed(6));
  const most = end === "low" ? clip.high[axis] - leastThickness : 1;
  const least = end === "low" ? 0 : clip.low[axis] + leastThickness;
  const moved: Triple = [...clip[end]];
  moved[axis] = round(Math.max(least, Math.min(most, share)));
  return { ...clip, [end]: moved };
}

/** The share to which a key moves a face; undefined if the key has no effect here. */
export function shareAfterKey(key: string, share: number, isShifted: boolean): number | undefined {
  const step = isShifted ? 0.1 : 0.01;
  const steps: Record<string, number> = {
    ArrowLeft: share - step,
    ArrowDown: share - step,
    ArrowRight: share + step,
    ArrowUp: share + step,
    PageDown: share - 0.1,
    PageUp: share + 0.1,
    Home: 0,
    End: 1,
  };
  return steps[key];
}

function middleOf({ low, high }: Clip): Triple {
  return [(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, (low[2] + high[2]) / 2];
}

function faceMiddle(clip: Clip, face: ClipFace): Triple {
  const shares = middleOf(clip);
  shares[face.axis] = shareOf(clip, face);
  return shares;
}

/**
 * The position of the middle of a face; `isBehind`: the box is in front of it. Undefined behind the
 * eye.
 */
export function faceOnScreen(
  info: StoreInfo,
  screen: Screen,
  clip: Clip,
  face: ClipFace,
): (ScreenPoint & { isBehind: boolean }) | undefined {
  const at = screen.point(positionAt(info, faceMiddle(clip, face)));
  const middle = screen.point(positionAt(info, middleOf(clip)));
  return at && { ...at, isBehind: middle !== undefined && at.depth > middle.depth };
}

/** The twelve edges of the clip box, except those that extend behind the eye. */
export function clipEdges(
  info: StoreInfo,
  screen: Screen,
  { low, high }: Clip,
): { from: ScreenPoint; to: ScreenPoint }[] {
  const corner = (number: number) =>
    screen.point(
      positionAt(info, [
        number & 1 ? high[0] : low[0],
        number & 2 ? high[1] : low[1],
        number & 4 ? high[2] : low[2],
      ]),
    );
  const corners = [0, 1, 2, 3, 4, 5, 6, 7].map(corner);
  return corners.flatMap((from, number) =>
    [1, 2, 4].flatMap((bit) => {
      const to = corners[number | bit];
      return (number & bit) === 0 && from && to ? [{ from, to }] : [];
    }),
  );
}

/**
 * The share at which a face follows the pointer, which has moved by these pixels since the face was
 * grabbed. `grabbed`: the clip at that time.
 */
export function draggedShare(
  info: StoreInfo,
  screen: Screen,
  grabbed: Clip,
  face: ClipFace,
  { right, down }: { right: number; down: number },
): number {
  const from = shareOf(grabbed, face);
  const start = positionAt(info, faceMiddle(grabbed, face));
  const ahead = faceMiddle(grabbed, face);
  ahead[face.axis] += 1;
  const [x, y, z] = positionAt(info, ahead);
  const motion = screen.motion(start, [x - start[0], y - start[1], z - start[2]]);
  if (!motion) return from;
  // The component of the drag along the projected axis, and the step that corresponds to it.
  const squared = Math.max(motion.right ** 2 + motion.down ** 2, leastPixels ** 2);
  const along = (right * motion.right + down * motion.down) / squared;
  const rest = 1 - along * motion.nearing;
  // Beyond the vanishing point there is no step.
  const step = rest > 0 ? along / rest : Math.sign(along);
  return Math.round((from + step) / dragStep) * dragStep;
}
