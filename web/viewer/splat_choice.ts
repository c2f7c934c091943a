import type { DrawStatistics } from "./renderer_module.ts";
import type { SplatKind } from "./types.ts";

/** If ellipses take longer than this (ms), squares replace them while something moves. */
const slowEllipses = 50;
/** If squares take less than this (ms), ellipses replace them, which take up to three times as long. */
const fastSquares = 14;
/** The longest picture at rest (ms). With longer ones the page would seem to hang. */
const longestRest = 1000;
/** If frames during movement take longer than this (ms), exact ones would take too long. */
const hopelessMotion = 400;
/** If the distance of the eye changes by this factor, earlier measurements do not count any more. */
const otherDistance = 1.3;

type MeasuredFrame = Pick<DrawStatistics, "kind" | "programsLinked">;

/**
 * Chooses the splat kind for "automatic": fast splats while something moves, the exact surface at rest,
 * or cheaper ones if this GPU is too slow. Uses the measured duration of frames, not the GPU's name.
 */
export class SplatChoice {
  #moving: "ellipse" | "quad" = "ellipse";
  #lastMoving = 0;
  #slowExactAt = 0;

  /** distance: from the eye to its target. */
  kind(isResting: boolean, distance: number): SplatKind {
    if (!isResting) return this.#moving;
    if (this.#slowExactAt > 0) {
      const ratio = distance / this.#slowExactAt;
      if (ratio < otherDistance && ratio > 1 / otherDistance) return "ellipse";
      this.#slowExactAt = 0;
    }
    return this.#lastMoving > hopelessMotion ? "ellipse" : "exact";
  }

  /** Reports the duration of a frame on the GPU. Frames that linked shader programs do not count. */
  measured(frame: MeasuredFrame, milliseconds: number, distance: number): void {
    if (frame.programsLinked > 0) return;
    const { kind } = frame;
    if (kind === "exact") {
      if (milliseconds > longestRest) this.#slowExactAt = distance;
      return;
    }
    this.#lastMoving = milliseconds;
    if (kind === "ellipse" && milliseconds > slowEllipses) this.#moving = "quad";
    if (kind === "quad" && milliseconds < fastSquares) this.#moving = "ellipse";
  }
}
