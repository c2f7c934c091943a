import type { DrawStatistics } from "./renderer_module.ts";
import type { SplatKind } from "./types.ts";

/** Ellipses that take longer (ms) give way to squares while something moves. */
const slowEllipses = 50;
/** Squares that are faster (ms) give way to ellipses, which take up to three times as long. */
const fastSquares = 14;
/** A resting picture may take so long (ms): longer, and the page seems to hang. */
const longestRest = 1000;
/** Moving frames that take longer (ms) say that exact ones would take too long. */
const hopelessMotion = 400;
/** The eye has moved so much nearer or farther that what was measured says nothing any more. */
const otherDistance = 1.3;

type MeasuredFrame = Pick<DrawStatistics, "kind" | "programsLinked">;

/**
 * What the kind "automatic" draws: fast splats while something moves, the exact surface when it
 * rests, each as far as this GPU can. Judged by what frames took, not by the GPU's name.
 */
export class SplatChoice {
  #moving: "ellipse" | "quad" = "ellipse";
  #lastMoving = 0;
  #slowExactAt = 0;

  /** `distance`: of the eye from its target. */
  kind(isResting: boolean, distance: number): SplatKind {
    if (!isResting) return this.#moving;
    if (this.#slowExactAt > 0) {
      const ratio = distance / this.#slowExactAt;
      if (ratio < otherDistance && ratio > 1 / otherDistance) return "ellipse";
      this.#slowExactAt = 0;
    }
    return this.#lastMoving > hopelessMotion ? "ellipse" : "exact";
  }

  /** A frame took so long on the GPU. One that had to link programs says nothing of the next ones. */
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
