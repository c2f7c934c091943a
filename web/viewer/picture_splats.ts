import type { DrawStatistics } from "./renderer_module.ts";
import type { Scene } from "./scene.ts";
import { SplatChoice } from "./splat_choice.ts";
import type { Look, Splats } from "./types.ts";

/** The splats of the next picture, which depend on those of the last one and on its duration. */
export class PictureSplats {
  readonly #choice = new SplatChoice();
  /** Duration (ms) and splats of the last measured picture. */
  #took: (Splats & { milliseconds: number }) | null = null;
  #drawn: Splats | undefined;
  /** The shading of the scene when the last picture was drawn. */
  #requestedShading: Look["shading"] | undefined;

  /** Duration of the last measured picture (ms); 0 before it. */
  get milliseconds(): number {
    return this.#took?.milliseconds ?? 0;
  }

  /** The splats of a picture that replaces the present one. */
  ofOther({ kind, shading, camera }: Scene, isResting: boolean): Splats {
    const chosen = this.#choice.splats(isResting, camera.distance);
    if (kind === "automatic") return shading === "exact" ? { ...chosen, shading } : chosen;
    return { kind, shading: isResting || kind === "quad" ? shading : "exact" };
  }

  /** The splats to draw now. needsRedraw: whether the present picture is out of date. */
  next(scene: Scene, isResting: boolean, needsRedraw: boolean): Splats {
    const kept = needsRedraw ? undefined : this.#toKeep(scene, isResting);
    return kept ?? this.ofOther(scene, isResting);
  }

  /**
   * The splats of the present picture, if nothing has changed and nothing finer must be drawn. The
   * measured duration of a picture affects later pictures, but is no reason to draw this one again.
   */
  #toKeep({ kind, shading }: Scene, isResting: boolean): Splats | undefined {
    const drawn = this.#drawn;
    if (kind !== "automatic" || shading !== this.#requestedShading) return undefined;
    return !isResting || drawn?.kind === "exact" ? drawn : undefined;
  }

  /** Whether the last picture with these splats took at most this time (ms). */
  isFast(longest: number, { kind, shading }: Splats): boolean {
    const took = this.#took;
    return took?.kind === kind && took.shading === shading && took.milliseconds <= longest;
  }

  /** A picture of the scene was drawn. */
  drawn({ shading }: Scene, { kind, shading: drawnShading }: DrawStatistics): void {
    this.#drawn = { kind, shading: drawnShading };
    this.#requestedShading = shading;
  }

  /** Reports how long the GPU took for such a picture. */
  measured({ camera }: Scene, drawn: DrawStatistics, milliseconds: number): void {
    this.#choice.measured(drawn, milliseconds, camera.distance);
    this.#took = { kind: drawn.kind, shading: drawn.shading, milliseconds };
  }
}
