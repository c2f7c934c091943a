import type { OcclusionQuery } from "../stream/occlusion_queries.ts";
import type { StreamSession } from "../stream/session.ts";
import type { RendererModule } from "./renderer_module.ts";
import type { SceneLayer } from "./scene.ts";

/** Interval between checks whether the GPU has finished a test (ms). */
const polling = 8;

/** The functions that the tester needs from its viewer. */
export interface TestedViewer {
  /** Runs an action of the renderer; returns whether it succeeded. */
  guard(action: (renderer: RendererModule) => void): boolean;
  /** Whether nothing moves and the GPU is idle, so that an answer can be read without waiting. */
  isIdle(): boolean;
  /** The time (as of performance.now()) until which something moves, so that `isIdle` is false. */
  movesUntil(): number;
  isContextLost(): boolean;
  /** The session has an answer; settled: for a picture at rest. `ended` follows. */
  answered(settled: boolean): void;
  /** A test has ended. Actions that waited for this continue. */
  ended(): void;
}

/** The part of a layer that its tests need. */
export type TestedLayer = Pick<SceneLayer, "number" | "session">;

/**
 * Runs occlusion queries when streaming requests them, to find the regions that must be refined.
 */
export class OcclusionTester {
  readonly #viewer: TestedViewer;
  #timer = 0;
  /** The layer that was tested last. The others get their turn before it. */
  #last = -1;

  constructor(viewer: TestedViewer) {
    this.#viewer = viewer;
  }

  /**
   * Whether the answer of a test is pending. Reading it would also wait for commands sent
   * meanwhile.
   */
  get isRunning(): boolean {
    return this.#timer !== 0;
  }

  /**
   * Tests the present picture for the next layer whose session requests it. settled: the picture is already
   * drawn in the quality of a view at rest.
   */
  test(layers: readonly TestedLayer[], settled: boolean): void {
    if (this.isRunning) return;
    const next = layers.filter(({ number }) => number > this.#last);
    const before = layers.filter(({ number }) => number <= this.#last);
    for (const { number, session } of [...next, ...before]) {
      const query = session.occlusionQuery(settled);
      if (!query) continue;
      this.#last = number;
      this.#run(number, session, query, settled);
      return;
    }
  }

  #run(number: number, session: StreamSession, query: OcclusionQuery, settled: boolean): void {
    const wait = (): number => Math.max(polling, this.#viewer.movesUntil() - performance.now());
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
        this.#viewer.answered(settled);
        this.#viewer.ended();
      } else if (isAsked) {
        this.#timer = window.setTimeout(poll, wait());
      } else {
        this.#failed(session);
      }
    };
    if (
      this.#viewer.guard((renderer) =>
        renderer.beginOcclusionQuery(number, query.ids, query.minPixels),
      )
    ) {
      this.#timer = window.setTimeout(poll, wait());
    } else {
      this.#failed(session);
    }
  }

  /** Reports a failed test: the session continues without answers. A lost context resets it anyway. */
  #failed(session: StreamSession): void {
    if (this.#viewer.isContextLost()) return;
    session.fetchOccluded();
    this.#viewer.ended();
  }

  stop(): void {
    clearTimeout(this.#timer);
    this.#timer = 0;
  }
}
