import type { DrawStatistics } from "./renderer_module.ts";
import type { Splats } from "./types.ts";

/** If ellipses take longer than this (ms), squares replace them while something moves. */
const slowEllipses = 50;
/** If squares take less than this (ms), ellipses replace them, which take up to three times as long. */
const fastSquares = 14;
/** The longest picture at rest (ms). With longer ones the page would seem to hang. */
const longestRest = 1000;
/** If frames during movement take longer than this (ms), exact ones would take too long. */
const hopelessMotion = 400;
/** If the distance of the eye changes by this factor, earlier measurements are discarded. */
const otherDistance = 1.3;

type MeasuredFrame = Pick<DrawStatistics, "kind" | "shading" | "programsLinked">;

/**
 * The distance of the eye at which a picture took too long, until the view has another distance.
 */
class SlowView {
  #distance = 0;

  found(distance: number): void {
    this.#distance = distance;
  }

  isAt(distance: number): boolean {
    const ratio = distance / this.#distance;
    const isHere = ratio < otherDistance && ratio > 1 / otherDistance;
    if (!isHere) this.#distance = 0;
    return isHere;
  }
}

/**
 * Chooses the splats for the kind "automatic": fast ones while something moves, the exact surface with
 * smooth normals at rest, or cheaper ones if this GPU is too slow. Uses the measured duration of frames,
 * not the GPU's name.
 */
export class SplatChoice {
  #moving: "ellipse" | "quad" = "ellipse";
  #lastMoving = 0;
  readonly #slowExact = new SlowView();
  readonly #slowSmooth = new SlowView();

  /** distance: from the eye to its target. */
  splats(isResting: boolean, distance: number): Splats {
    // Squares have smooth normals in close-ups only, where these cost little.
    if (!isResting) {
      return { kind: this.#moving, shading: this.#moving === "quad" ? "smooth" : "exact" };
    }
    if (this.#slowExact.isAt(distance) || this.#lastMoving > hopelessMotion) {
      return { kind: "ellipse", shading: "exact" };
    }
    return { kind: "exact", shading: this.#slowSmooth.isAt(distance) ? "exact" : "smooth" };
  }

  /** Reports the duration of a frame on the GPU. Frames that linked shader programs do not count. */
  measured(frame: MeasuredFrame, milliseconds: number, distance: number): void {
    if (frame.programsLinked > 0) return;
    const { kind } = frame;
    if (kind === "exact") {
      const slow = frame.shading === "smooth" ? this.#slowSmooth : this.#slowExact;
      if (milliseconds > longestRest) slow.found(distance);
      return;
    }
    this.#lastMoving = milliseconds;
    if (kind === "ellipse" && milliseconds > slowEllipses) this.#moving = "quad";
    if (kind === "quad" && milliseconds < fastSquares) this.#moving = "ellipse";
  }
}
