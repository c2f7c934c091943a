/** A movement ends when nothing has changed for this time (ms). Changes that are further apart are single. */
const movementGap = 220;
/**
 * After a single change, and after the last arrival, the view is at rest when nothing has changed for this
 * time (ms). A gesture continues earlier.
 */
const restAfter = 60;
/**
 * The same while more data are in flight, or may be needed (ms). Otherwise a slow GPU would draw
 * the exact picture several times, and software renderers would take the time that decoding needs.
 */
const restWhileStreaming = { afterMotion: 500, afterArrival: 1500 };

/** Decides when a view is at rest. All times are in ms, as of `performance.now()`. */
export class RestClock {
  #lastMotion = Number.NEGATIVE_INFINITY;
  #lastArrival = Number.NEGATIVE_INFINITY;
  /** Whether the last change belongs to a movement. */
  #isMovement = false;
  /** Data of the present view are in flight, or will be requested. */
  isStreaming = false;

  /** The camera, the surfaces or their look has changed. */
  moved(now: number): void {
    this.#isMovement = now < this.#lastMotion + movementGap;
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

  /** The time when `isMoving` ends if nothing moves until then. A single change is no movement. */
  get movesUntil(): number {
    return this.#lastMotion + (this.#isMovement ? movementGap : 0);
  }

  /** The time when the view rests if nothing moves or arrives until then. */
  get restsAt(): number {
    const afterChange = this.#isMovement ? movementGap : restAfter;
    const always = { afterMotion: afterChange, afterArrival: restAfter };
    const { afterMotion, afterArrival } = this.isStreaming ? restWhileStreaming : always;
    return Math.max(this.#lastMotion + afterMotion, this.#lastArrival + afterArrival);
  }
}
