/** The view is at rest when nothing has moved or arrived for this time (ms). */
const restAfter = 220;
/**
 * The same while more data are in flight, or may be needed (ms): a slow GPU would otherwise draw the
 * exact picture several times, and software renderers would take the time that decoding needs.
 */
const restWhileStreaming = { afterMotion: 500, afterArrival: 1500 };

/** Decides when a view is at rest. All times are in ms, as of `performance.now()`. */
export class RestClock {
  #lastMotion = Number.NEGATIVE_INFINITY;
  #lastArrival = Number.NEGATIVE_INFINITY;
  /** Data of the present view are in flight, or will be requested. */
  isStreaming = false;

  /** The camera, the surfaces or their look has changed. */
  moved(now: number): void {
    this.#lastMotion = now;
  }

  /** The set of chunks to draw has changed. */
  arrived(now: number): void {
    this.#lastArrival = now;
  }

  /**
   * The occlusion query of a fast picture was answered. What it found is requested next: otherwise a
   * fast picture that takes longer than `restWhileStreaming` would be followed by an exact one, and
   * that one would be drawn again with the chunks.
   */
  fastPictureTested(now: number): void {
    if (this.isStreaming) this.arrived(now);
  }

  /** Nothing more arrives until the picture at rest has been drawn. */
  restNow(): void {
    this.#lastMotion = Number.NEGATIVE_INFINITY;
    this.#lastArrival = Number.NEGATIVE_INFINITY;
  }

  isMoving(now: number): boolean {
    return now < this.movesUntil;
  }

  /** When `isMoving` ends if nothing moves until then. */
  get movesUntil(): number {
    return this.#lastMotion + restAfter;
  }

  /** When the view rests if nothing moves or arrives until then. */
  get restsAt(): number {
    const always = { afterMotion: restAfter, afterArrival: restAfter };
    const { afterMotion, afterArrival } = this.isStreaming ? restWhileStreaming : always;
    return Math.max(this.#lastMotion + afterMotion, this.#lastArrival + afterArrival);
  }
}
