const pollMs = 8;
/** A frame is asked for first after this share of what the last one took. */
const firstPollShare = 0.5;
/** What was sent longer ago (ms) says nothing of how the GPU does now. */
const longestBeat = 50;
/** A GPU that has not answered at once when asked so many times will not: what waits for that goes on. */
const maxAsked = 40;

/**
 * How long frames take on the GPU, by fences: a call that draws returns long before the picture is
 * there. One frame at a time; those that begin meanwhile are not measured.
 */
export class GpuTimer {
  readonly #gl: WebGL2RenderingContext;
  #timer = 0;
  #lastTook = 0;

  constructor(gl: WebGL2RenderingContext) {
    this.#gl = gl;
  }

  /** A frame is being drawn. */
  get isBusy(): boolean {
    return this.#timer !== 0;
  }

  /** Call right after a frame's commands. `done` is told the milliseconds since `startedAt`. */
  measure(startedAt: number, done: (milliseconds: number) => void): void {
    if (this.#timer !== 0) return;
    const gl = this.#gl;
    const fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    if (!fence) return; // the context is lost
    gl.flush();
    const poll = () => {
      this.#timer = 0;
      if (gl.isContextLost()) return;
      if (gl.getSyncParameter(fence, gl.SYNC_STATUS) === gl.SIGNALED) {
        gl.deleteSync(fence);
        this.#lastTook = performance.now() - startedAt;
        done(this.#lastTook);
      } else {
        this.#timer = window.setTimeout(poll, pollMs);
      }
    };
    this.#timer = window.setTimeout(poll, Math.max(pollMs, firstPollShare * this.#lastTook));
  }

  /** Whatever is being drawn is not waited for: it is of no interest, or was lost with the context. */
  stop(): void {
    clearTimeout(this.#timer);
    this.#timer = 0;
  }
}

/**
 * Whether the GPU answers at once. What is read back from it waits for all that was sent before,
 * also by the browser, which draws the page with it.
 */
export class GpuPulse {
  readonly #gl: WebGL2RenderingContext;
  #fence: WebGLSync | null = null;
  #sentAt = 0;
  #isLate = false;
  /** Times since it last beat. */
  #asked = 0;

  constructor(gl: WebGL2RenderingContext) {
    this.#gl = gl;
  }

  /** The context is lost: fences of it mean nothing to the one that comes after it. */
  contextLost(): void {
    this.#fence = null;
    this.#isLate = false;
    this.#asked = 0;
  }

  /**
   * Call it every few milliseconds until it says so: what was sent at the last call had been done
   * when it was first looked at. On a machine that is always busy that never happens: after
   * `maxAsked` calls it says so as well.
   */
  beats(): boolean {
    const beats = this.#isAnsweredAtOnce() || ++this.#asked >= maxAsked;
    if (beats) this.#asked = 0;
    return beats;
  }

  #isAnsweredAtOnce(): boolean {
    const gl = this.#gl;
    const now = performance.now();
    const fence = this.#fence;
    if (fence && gl.getSyncParameter(fence, gl.SYNC_STATUS) === gl.UNSIGNALED) {
      this.#isLate = true;
      return false;
    }
    const isInTime = fence !== null && !this.#isLate && now - this.#sentAt <= longestBeat;
    gl.deleteSync(fence);
    this.#fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    this.#sentAt = now;
    this.#isLate = false;
    gl.flush();
    return isInTime;
  }
}
