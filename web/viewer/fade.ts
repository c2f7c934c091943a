import type { RendererModule } from "./renderer_module.ts";

/** A picture gives way to a finer one over so long (ms). */
const duration = 160;

/**
 * Lets finer pictures of a still view come in the place of coarser ones step by step, where they
 * would else pop up.
 */
export class Fade {
  readonly #renderer: RendererModule;
  /** A picture is held that looks like the present one, but for what has arrived since. */
  #holds = false;
  #startedAt: number | undefined;

  constructor(renderer: RendererModule) {
    this.#renderer = renderer;
  }

  get isRunning(): boolean {
    return this.#startedAt !== undefined;
  }

  /** The next picture shows something else: it is to be there at once. */
  forget(): void {
    this.#holds = false;
    this.#startedAt = undefined;
  }

  /** Before a draw: a fade that is under way goes on from where it is. */
  beforeDraw(now: number): void {
    if (this.#startedAt === undefined) return;
    this.#renderer.fade(this.#progress(now));
    this.#renderer.holdPicture();
  }

  /** Right after a draw. `isMoreToCome`: the next picture is to come in the place of this one. */
  afterDraw(now: number, isMoreToCome: boolean): void {
    if (this.#holds && this.#renderer.beginFade()) {
      this.#startedAt = now;
    } else if (isMoreToCome) {
      this.#renderer.holdPicture();
      this.#holds = true;
    }
  }

  /** In a frame that draws nothing. */
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
