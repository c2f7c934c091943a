/** The view is at rest when nothing has moved or arrived for this time (ms). */
const restAfter = 220;
/**
 * The same while more data are in flight, or may be needed (ms). Otherwise a slow GPU would draw
 * the exact picture several times, and software renderers would take the time that decoding needs.
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
   * The occlusion query of a fast picture was answered. The chunks that it found are requested
   * next. Without this, a fast picture that takes longer than `restWhileStreaming` would be
   * followed by an exact one, which would be drawn again with those chunks.
   */
  fastPictureTested(now: number): void {
    if (this.isStreaming) this.arrived(now);
  }

  /** Rests now, since nothing more arrives until the picture at rest has been drawn. */
  restNow(): void {
    this.#lastMotion = Number.NEGATIVE_INFINITY;
    this.#lastArrival = Number.NEGATIVE_INFINITY;
  }

  isMoving(now: number): boolean {
    return now < this.movesUntil;
  }

  /** The time when `isMoving` ends if nothing moves until then. */
  get movesUntil(): number {
    return this.#lastMotion + restAfter;
  }

  /** The time when the view rests if nothing moves or arrives until then. */
  get restsAt(): number {
    const always = { afterMotion: restAfter, afterArrival: restAfter };
    const { afterMotion, afterArrival } = this.isStreaming ? restWhileStreaming : always;
    return Math.max(this.#lastMotion + afterMotion, this.#lastArrival + afterArrival);
  }
}
