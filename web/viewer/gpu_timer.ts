const pollMs = 8;

/**
 * How long frames take on the GPU, by fences: a call that draws returns long before the picture is
 * there. One frame at a time; those that begin meanwhile are not measured.
 */
export class GpuTimer {
  readonly #gl: WebGL2RenderingContext;
  #timer = 0;

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
        done(performance.now() - startedAt);
      } else {
        this.#timer = window.setTimeout(poll, pollMs);
      }
    };
    this.#timer = window.setTimeout(poll, pollMs);
  }

  stop(): void {
    clearTimeout(this.#timer);
    this.#timer = 0;
  }
}
