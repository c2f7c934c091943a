/** A frame belongs to the same run as the previous one if it follows within this time (ms). */
const sameRun = 40;

/**
 * Draws on demand: `request` requests one frame, and the callback returns whether another one must
 * follow. A still view causes no work.
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

  /** Whether a frame has been requested. */
  get isRequested(): boolean {
    return this.#handle !== 0;
  }

  stop(): void {
    cancelAnimationFrame(this.#handle);
    this.#handle = 0;
  }

  /** Frames per second of the last run; 0 if there was none. */
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
    // Only frames that were requested right after the previous one are a run. Later requests, for
    // example for chunks that arrive now and then, do not measure how fast frames can be.
    if (this.#askedAt - before < sameRun && interval < 1000) {
      this.#intervals.push(interval);
      if (this.#intervals.length > 30) this.#intervals.shift();
    }
    if (this.#draw(now)) this.request();
  };
}
