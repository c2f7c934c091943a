/** Milliseconds after a frame within which the next one belongs to the same run. */
const sameRun = 40;

/**
 * Draws on demand. `request` asks for one frame; the callback says whether another is to follow. A
 * view that stands still costs nothing.
 */
export class FrameLoop {
  readonly #draw: (now: number) => boolean;
  #handle = 0;
  #lastFrame = 0;
  #askedAt = 0;
  /** Milliseconds between the last frames of a run, newest last. */
  readonly #intervals: number[] = [];

  constructor(draw: (now: number) => boolean) {
    this.#draw = draw;
  }

  request(): void {
    if (this.#handle !== 0) return;
    this.#askedAt = performance.now();
    this.#handle = requestAnimationFrame(this.#frame);
  }

  /** A frame is to come. */
  get isRequested(): boolean {
    return this.#handle !== 0;
  }

  stop(): void {
    cancelAnimationFrame(this.#handle);
    this.#handle = 0;
  }

  /** Of the last frames that followed one another; 0 while there were none. */
  get framesPerSecond(): number {
    if (this.#intervals.length < 2) return 0;
    const sum = this.#intervals.reduce((total, interval) => total + interval, 0);
    return (1000 * this.#intervals.length) / sum;
  }

  readonly #frame = (now: number): void => {
    this.#handle = 0;
    const before = this.#lastFrame;
    const interval = now - before;
    this.#lastFrame = now;
    // Asked for soon after the last frame: one run. Later, it was not waited for, as when a chunk
    // arrives now and then; that says nothing of how fast frames can be.
    if (this.#askedAt - before < sameRun && interval < 1000) {
      this.#intervals.push(interval);
      if (this.#intervals.length > 30) this.#intervals.shift();
    }
    if (this.#draw(now)) this.request();
  };
}
