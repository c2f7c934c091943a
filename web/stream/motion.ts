import { sameNumbers } from "./same_numbers.ts";
import type { CameraView } from "./types.ts";

/** A change that follows another within this time is part of a movement (ms). */
const movementGap = 180;
/** Chunks are prefetched for the isovalue expected after this time (s). */
const lookAhead = 0.4;
/**
 * A larger change within `lookAhead`, as a share of the range, is too fast for prefetching. The limit
 * is lower if finer levels are resident for every isovalue, because a movement then has fine cells
 * without requests.
 */
const maxLeap = { coarse: 0.08, prepared: 0.02 };
/** Shortest time between two prefetches (ms). */
const prefetchInterval = 250;
/**
 * The shortest and longest time over which the speed of an isovalue is measured (ms). Two quick changes
 * are not enough.
 */
const speedSpan = { min: 100, max: 300 };

/** Detects movement of the camera or the isovalue from the sequence of camera views. */
export class Motion {
  readonly #rested: () => void;
  #view: CameraView | undefined;
  #cameraChanged = Number.NEGATIVE_INFINITY;
  #isovalueChanged = Number.NEGATIVE_INFINITY;
  #isovalueMoves = false;
  #cameraMoves = false;
  #direction = 0;
  /** The latest of the movement's isovalues, and when they were set. */
  #trail: { at: number; isovalues: readonly number[] }[] = [];
  #lastAhead = Number.NEGATIVE_INFINITY;
  #timer: ReturnType<typeof setTimeout> | undefined;

  /** `rested` is called when a movement ends. */
  constructor(rested: () => void) {
    this.#rested = rested;
  }

  /** The last camera view that differed from the one before; undefined before the first. */
  get view(): CameraView | undefined {
    return this.#view;
  }

  /** Whether the isovalue changes repeatedly, as with a slider. A single change is no movement. */
  get isovalueMoves(): boolean {
    return this.#isovalueMoves;
  }

  /** The direction of the isovalues' last change: −1 or 1; 0 before the first, or if it is unclear. */
  get direction(): number {
    return this.#direction;
  }

  get cameraMoves(): boolean {
    return this.#cameraMoves;
  }

  /**
   * Sets the camera view. Returns whether it differs from the previous one, or movement has started or
   * ended.
   */
  changed(view: CameraView): boolean {
    const before = this.#view;
    if (!before) {
      this.#view = copyOf(view);
      return true;
    }
    const now = performance.now();
    const cameraMoved = !sameNumbers(before.viewProjection, view.viewProjection);
    const isovaluesMoved = !sameNumbers(before.isovalues, view.isovalues);
    if (cameraMoved) this.#cameraChanged = now;
    const wasMoving = this.#cameraMoves;
    this.#cameraMoves = view.moving && now - this.#cameraChanged < movementGap;
    if (isovaluesMoved) {
      const gap = now - this.#isovalueChanged;
      this.#isovalueMoves = gap < movementGap;
      this.#isovalueChanged = now;
      this.#direction = directionOf(before.isovalues, view.isovalues);
      const goesOn = this.#isovalueMoves && before.isovalues.length === view.isovalues.length;
      const trail = goesOn ? this.#trail.filter(({ at }) => now - at <= speedSpan.max) : [];
      this.#trail = [...trail, { at: now, isovalues: [...view.isovalues] }];
    }
    if (this.#isovalueMoves || this.#cameraMoves) this.#watch();
    const resized =
      before.viewport.width !== view.viewport.width ||
      before.viewport.height !== view.viewport.height;
    const isOther =
      cameraMoved || isovaluesMoved || resized || before.stepCellPixels !== view.stepCellPixels;
    if (isOther) this.#view = copyOf(view);
    return isOther || wasMoving !== this.#cameraMoves;
  }

  /**
   * The isovalues expected after `lookAhead`, or undefined if it is too early for another prefetch or
   * the isovalues move too fast. `range`: length of the volume's range of values. `isPrepared`: the
   * BackgroundLoader has finished.
   */
  isovaluesAhead(range: number, isPrepared: boolean): number[] | undefined {
    const now = performance.now();
    const first = this.#trail[0];
    const last = this.#trail.at(-1);
    if (!first || !last || last.at - first.at < speedSpan.min) return undefined;
    if (!this.#goesOneWay()) return undefined;
    const leaps = last.isovalues.map((isovalue, i) => {
      const perSecond =
        ((isovalue - (first.isovalues[i] ?? isovalue)) / (last.at - first.at)) * 1000;
      return perSecond * lookAhead;
    });
    const furthest = Math.max(...leaps.map(Math.abs));
    const limit = isPrepared ? maxLeap.prepared : maxLeap.coarse;
    if (furthest === 0 || furthest > limit * range) return undefined;
    if (now - this.#lastAhead < prefetchInterval) return undefined;
    this.#lastAhead = now;
    return last.isovalues.map((isovalue, i) => isovalue + (leaps[i] ?? 0));
  }

  /** Whether the isovalues move in one direction. Two changes are too few to decide it. */
  #goesOneWay(): boolean {
    const goes = (sign: number): boolean =>
      this.#trail.every(({ isovalues }, i) => {
        const before = this.#trail[i - 1]?.isovalues ?? isovalues;
        return isovalues.every((isovalue, k) => sign * (isovalue - (before[k] ?? isovalue)) >= 0);
      });
    return this.#trail.length > 2 && (goes(1) || goes(-1));
  }

  close(): void {
    clearTimeout(this.#timer);
  }

  #watch(): void {
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => {
      this.#isovalueMoves = false;
      this.#cameraMoves = false;
      this.#trail = [];
      this.#rested();
    }, movementGap);
  }
}

/** The sign of the sum of all changes; 0 if isovalues were added or removed. */
function directionOf(before: readonly number[], after: readonly number[]): number {
  if (before.length !== after.length) return 0;
  return Math.sign(after.reduce((sum, value, i) => sum + value - (before[i] ?? value), 0));
}

function copyOf(view: CameraView): CameraView {
  return {
    ...view,
    viewProjection: Array.from(view.viewProjection),
    isovalues: [...view.isovalues],
  };
}
