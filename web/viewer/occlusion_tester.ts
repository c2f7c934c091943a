import type { StreamSession } from "../stream/index.ts";
import type { RendererModule } from "./renderer_module.ts";

/** The GPU is asked so often whether a test is done (ms). */
const polling = 8;

/** What the tester asks of its viewer. */
export interface TestedViewer {
  /** Does what may fail in the renderer; answers whether it did not. */
  guard(action: (renderer: RendererModule) => void): boolean;
  /** Nothing moves, and the GPU has nothing to do: an answer can be read without waiting. */
  isIdle(): boolean;
  isContextLost(): boolean;
  /** A test has ended; what waited for that goes on. */
  ended(): void;
}

/** Finds out, where streaming asks for it, what of a picture may be seen more finely. */
export class OcclusionTester {
  readonly #viewer: TestedViewer;
  #timer = 0;

  constructor(viewer: TestedViewer) {
    this.#viewer = viewer;
  }

  /** A test's answer is awaited: it would wait for whatever is drawn meanwhile. */
  get isRunning(): boolean {
    return this.#timer !== 0;
  }

  /**
   * Tests the picture as it is drawn, if its session wants that. `settled`: when the view rests, it
   * is drawn no differently.
   */
  test(session: StreamSession, settled: boolean): void {
    if (this.isRunning) return;
    const query = session.occlusionQuery(settled);
    if (!query) return;
    const poll = (): void => {
      this.#timer = 0;
      if (this.#viewer.isContextLost()) return;
      if (session.isClosed) {
        this.#viewer.ended();
        return;
      }
      let answer: Uint32Array | undefined;
      const isAsked = this.#viewer.guard((renderer) => {
        if (this.#viewer.isIdle()) answer = renderer.takeOcclusionQuery();
      });
      if (answer) {
        session.answerOcclusion(query, answer, settled);
        this.#viewer.ended();
      } else if (isAsked) {
        this.#timer = window.setTimeout(poll, polling);
      } else {
        this.#failed(session);
      }
    };
    if (
      this.#viewer.guard((renderer) => renderer.beginOcclusionQuery(query.ids, query.minPixels))
    ) {
      this.#timer = window.setTimeout(poll, polling);
    } else {
      this.#failed(session);
    }
  }

  /** The session goes on without answers; after a lost context it begins anew. */
  #failed(session: StreamSession): void {
    if (this.#viewer.isContextLost()) return;
    session.occlusionFailed();
    this.#viewer.ended();
  }

  stop(): void {
    clearTimeout(this.#timer);
    this.#timer = 0;
  }
}
