const pollMs = 8;
/** The first check for a frame happens after this share of the duration of the last one. */
const firstPollShare = 0.5;
/** Fences older than this (ms) are not used to judge whether the GPU responds. */
const longestBeat = 50;
/** After this many checks, a GPU that never responded at once counts as responding. */
const maxAsked = 40;

/**
 * Measures the duration of frames on the GPU by fences, because draw calls return long before the
 * picture is finished. Measures one frame at a time; frames that begin meanwhile are not measured.
 */
export class GpuTimer {
  readonly #gl: WebGL2RenderingContext;
  #timer = 0;
  #lastTook = 0;

  constructor(gl: WebGL2RenderingContext) {
    this.#gl = gl;
  }

  /** Whether a frame is being measured. */
  get isBusy(): boolean {
    return this.#timer !== 0;
  }

  /** Call right after a frame's commands. done: receives the milliseconds since startedAt. */
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

  /** Stops measuring, because the frame is not relevant any more, or was lost with the context. */
  stop(): void {
    clearTimeout(this.#timer);
    this.#timer = 0;
  }
}

/**
 * Finds out whether the GPU responds at once. Reading back from it waits for all commands sent before,
 * including those of the browser, which draws the page with the same GPU.
 */
export class GpuPulse {
  readonly #gl: WebGL2RenderingContext;
  #fence: WebGLSync | null = null;
  #sentAt = 0;
  #isLate = false;
  /** Number of checks since the GPU last responded at once. */
  #asked = 0;

  constructor(gl: WebGL2RenderingContext) {
    this.#gl = gl;
  }

  /** The context is lost: its fences are not valid in the next one. */
  contextLost(): void {
    this.#fence = null;
    this.#isLate = false;
    this.#asked = 0;
  }

  /**
   * Call every few milliseconds until it returns true. It returns true when the fence of the last
   * call was signalled at its first check. On a machine that is always busy this never happens, so
   * it also returns true after `maxAsked` calls.
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
