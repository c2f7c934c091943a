import type { Core } from "../core/core.ts";
import { loadCore } from "../core/load_core.ts";
import { RendererError } from "./renderer_error.ts";
import { RendererModule } from "./renderer_module.ts";

/** If a renderer fails within this time (ms) after it was replaced, it is not replaced again. */
const shortestLife = 30_000;

/** Interval in ms between checks whether the first shaders are compiled. */
const shaderPolling = 8;

/** The functions that RendererLife needs from its viewer. */
export interface RendererLifeHost {
  /** A renderer is ready. */
  made(renderer: RendererModule): void;
  /** Drawing has begun: shaders need no warming up any more. */
  isDrawing(): boolean;
  /** The instance has aborted: it must not be called any more. */
  aborted(): void;
  /** The volume must be opened again, with another instance or after a lost context. */
  reopen(): void;
  /** The renderer has failed twice within a short time. */
  givesUp(error: RendererError): void;
  /** An action has failed; the renderer continues. */
  failed(error: RendererError): void;
  /** The WebGL context was lost or restored. */
  contextChanged(state: "lost" | "restored"): void;
}

/**
 * The renderer of a canvas, and its replacement: creates it when it is first needed, again after its
 * instance has aborted, and follows losses of the WebGL context.
 */
export class RendererLife {
  readonly #canvas: HTMLCanvasElement;
  readonly #host: RendererLifeHost;
  #parts: Promise<{ renderer: RendererModule; core: Core }> | null = null;
  #renderer: RendererModule | null = null;
  #isContextLost = false;
  #isWarm = false;
  #isEnded = false;
  #replacedAt = Number.NEGATIVE_INFINITY;
  readonly #lost = (event: Event) => this.#onContextLost(event);
  readonly #restored = () => this.#onContextRestored();

  constructor(canvas: HTMLCanvasElement, host: RendererLifeHost) {
    this.#canvas = canvas;
    this.#host = host;
    canvas.addEventListener("webglcontextlost", this.#lost);
    canvas.addEventListener("webglcontextrestored", this.#restored);
  }

  /** Null before the first `load`, and after the instance has aborted. */
  get renderer(): RendererModule | null {
    return this.#renderer;
  }

  get isContextLost(): boolean {
    return this.#isContextLost;
  }

  get isEnded(): boolean {
    return this.#isEnded;
  }

  /**
   * Ends the viewer: nothing is created any more. Call `destroy` when nothing uses the renderer.
   */
  end(): void {
    this.#isEnded = true;
  }

  destroy(): void {
    this.#canvas.removeEventListener("webglcontextlost", this.#lost);
    this.#canvas.removeEventListener("webglcontextrestored", this.#restored);
    this.#renderer?.destroy();
  }

  /** The renderer, and the core of its instance. Rejects with a RendererError (no WebGL 2). */
  load(): Promise<{ renderer: RendererModule; core: Core }> {
    this.#parts ??= RendererModule.create(this.#canvas).then(async (renderer) => {
      if (this.#isEnded) {
        renderer.destroy();
        throw new DOMException("the viewer was disposed of", "AbortError");
      }
      this.#renderer = renderer;
      this.#host.made(renderer);
      return { renderer, core: await loadCore({ module: renderer.exports }) };
    });
    // After a failure, the next open() tries again.
    this.#parts.catch(() => {
      this.#parts = null;
    });
    return this.#parts;
  }

  /** Forgets an instance that has aborted: the next `load` creates another one. */
  forget(): void {
    this.#renderer = null;
    this.#parts = null;
  }

  /** Waits for the shaders without blocking the workers and the first samples. */
  warmUp(): void {
    if (this.#isWarm) return;
    setTimeout(
      () =>
        this.guard((renderer) => {
          if (this.#host.isDrawing() || this.#isWarm || this.#isEnded) return;
          this.#isWarm = renderer.isCompiled();
          if (this.#isWarm) renderer.warmUp();
          else this.warmUp();
        }),
      shaderPolling,
    );
  }

  /**
   * Runs `action`, which may fail, and returns whether it succeeded. A lost context is not an
   * error: it is restored later. Streaming reports a full GPU memory, and continues with a smaller
   * budget.
   */
  guard(action: (renderer: RendererModule) => void): boolean {
    if (!this.#renderer) return false;
    try {
      action(this.#renderer);
      return true;
    } catch (error) {
      if (this.#isWithoutContext()) return false;
      if (error instanceof RendererError) {
        if (error.kind !== "out-of-memory") this.#host.failed(error);
      } else if (error instanceof WebAssembly.RuntimeError) {
        this.replace(error);
      } else {
        // An error in JavaScript; the renderer still works.
        this.#host.failed(new RendererError(String(error), "internal", error));
      }
      return false;
    }
  }

  #isWithoutContext(): boolean {
    return this.#isContextLost || this.#canvas.getContext("webgl2")?.isContextLost() === true;
  }

  /**
   * Handles an instance that has aborted and cannot continue: opens the volume again with another
   * one.
   */
  replace(error: WebAssembly.RuntimeError): void {
    if (!this.#renderer) return;
    this.forget();
    this.#isWarm = false;
    this.#host.aborted();
    const givesUp = performance.now() - this.#replacedAt < shortestLife;
    this.#replacedAt = performance.now();
    // Use a separate task, not the call that has failed.
    setTimeout(() => {
      if (this.#isEnded) return;
      if (givesUp) {
        this.#host.givesUp(new RendererError(String(error), "renderer-failed", error));
        return;
      }
      // Losing the context frees the GPU memory of the old instance.
      const context = this.#canvas.getContext("webgl2");
      const loss = context?.getExtension("WEBGL_lose_context");
      if (!context || !loss || context.isContextLost()) {
        this.#host.reopen();
        return;
      }
      const restore = (): void => {
        this.#canvas.removeEventListener("webglcontextlost", restore);
        setTimeout(() => loss.restoreContext());
      };
      this.#canvas.addEventListener("webglcontextlost", restore);
      loss.loseContext();
    });
  }

  #onContextLost(event: Event): void {
    event.preventDefault(); // otherwise the browser does not restore it
    this.#isContextLost = true;
    this.#renderer?.contextLost();
    this.#host.contextChanged("lost");
  }

  /**
   * The chunks were lost with the context. They are fetched again, mostly from the browser's cache.
   */
  #onContextRestored(): void {
    this.#isContextLost = false;
    this.guard((renderer) => renderer.contextRestored());
    this.#host.contextChanged("restored");
    this.#host.reopen();
  }
}

/** The trap that caused an error, which shows that the instance has aborted. */
export function abortOf(error: unknown): WebAssembly.RuntimeError | undefined {
  for (let cause = error; cause instanceof Error; cause = cause.cause) {
    if (cause instanceof WebAssembly.RuntimeError) return cause;
  }
  return undefined;
}
