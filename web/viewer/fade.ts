import type { RendererModule } from "./renderer_module.ts";

/** Duration of a fade from one picture to the next (ms). */
const duration = 160;

/**
 * Fades from one picture to the next finer one of the same view, so that details do not pop up.
 */
export class Fade {
  readonly #renderer: RendererModule;
  readonly #mayFade: () => boolean;
  /**
   * Whether the renderer keeps a picture of the present view, from which the next one can fade in.
   */
  #holds = false;
  #startedAt: number | undefined;

  /** mayFade: whether the visitor accepts animations. */
  constructor(renderer: RendererModule, mayFade: () => boolean) {
    this.#renderer = renderer;
    this.#mayFade = mayFade;
  }

  get isRunning(): boolean {
    return this.#startedAt !== undefined;
  }

  /** The next picture shows something else, and must appear without a fade. */
  forget(): void {
    this.#holds = false;
    this.#startedAt = undefined;
  }

  /** Call before a draw. A running fade continues from its present state. */
  beforeDraw(now: number): void {
    if (this.#startedAt === undefined) return;
    this.#renderer.fade(this.#progress(now));
    this.#renderer.holdPicture();
  }

  /**
   * Draws the first picture with ambient occlusion and shadows, and fades to it. `draw` draws the
   * present picture once more, since the canvas does not keep it.
   */
  toOccluded(now: number, draw: () => void, drawOccluded: () => void): void {
    const fades = this.#mayFade();
    if (fades) {
      draw();
      this.#renderer.holdPicture();
    }
    drawOccluded();
    if (fades && this.#renderer.beginFade()) this.#startedAt = now;
  }

  /** Call right after a draw. isMoreToCome: the next picture fades in over this one. */
  afterDraw(now: number, isMoreToCome: boolean): void {
    if (!this.#mayFade()) {
      this.forget();
      return;
    }
    if (this.#holds && this.#renderer.beginFade()) {
      this.#startedAt = now;
    } else if (isMoreToCome) {
      this.#renderer.holdPicture();
      this.#holds = true;
    }
  }

  /** Call in a frame that draws nothing. */
  step(now: number, isMoreToCome: boolean): void {
    const progress = this.#progress(now);
    this.#renderer.fade(progress);
    if (progress < 1) return;
    this.#startedAt = undefined;
    this.#holds = isMoreToCome;
  }

  #progress(now: number): number {
    return Math.min(1, Math.max(0, (now - (this.#startedAt ?? now)) / duration));
  }
}
