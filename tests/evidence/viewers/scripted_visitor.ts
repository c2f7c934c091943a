/**
 * A visitor who follows a script, with the page's client in Node. The scripts below contain the
 * actions; their times and distances are random. There is no GPU, and so there are no occlusion
 * queries: the visitor also fetches chunks that the page would know to be occluded.
 */
import type { Core } from "../../../web/core/index.ts";
import { InlineDecoder, ServerSource, StreamSession } from "../../../web/stream/index.ts";
import type { Chance } from "../../support/chance.ts";
import { visitorField } from "./http2_fetch.ts";
import { VisitorCamera } from "./visitor_camera.ts";

/** Milliseconds between two steps of a gesture. */
const step = 50;

/** Pictures of a laptop's window, of a large window, and of a phone, in device pixels. */
const viewports = [
  { width: 688, height: 716 },
  { width: 1584, height: 880 },
  { width: 780, height: 1300 },
] as const;

const pause = (ms: number) => new Promise((resolve) => setTimeout(resolve, ms));

export class ScriptedVisitor {
  readonly chance: Chance;
  readonly #session: StreamSession;
  readonly #camera: VisitorCamera;
  readonly #viewport: (typeof viewports)[number];
  #isovalue: number;

  private constructor(session: StreamSession, chance: Chance) {
    this.chance = chance;
    this.#session = session;
    this.#viewport = chance.of(viewports);
    const { range, metadata } = session.info;
    this.#isovalue = metadata.suggested_isovalues?.[0] ?? (range[0] + range[1]) / 2;
    this.#camera = new VisitorCamera(session.info, this.#viewport.width / this.#viewport.height);
    this.#show(false);
  }

  /**
   * Opens a volume. `visitor`: the visitor's name, for `installFetch`. Errors of the client go to
   * `fail`.
   */
  static async arrive(
    core: Core,
    place: { base: string; volume: string },
    visitor: string,
    chance: Chance,
    fail: (error: Error) => void,
  ): Promise<ScriptedVisitor> {
    const source = new ServerSource({ ...place, headers: { [visitorField]: visitor } });
    const session = await StreamSession.open(source, core, {
      decoder: new InlineDecoder(core),
      // The budget of a desktop computer (web/stream/device.ts).
      sampleBudget: 24_000_000,
      events: {
        samples: () => true,
        drop: () => {},
        visible: () => {},
        progress: () => {},
        error: fail,
        replaced: fail,
      },
    });
    return new ScriptedVisitor(session, chance);
  }

  leave(): void {
    this.#session.close();
  }

  #show(moving: boolean): void {
    const { width, height } = this.#viewport;
    this.#session.update({
      viewProjection: this.#camera.viewProjection(width, height),
      viewport: { width, height },
      isovalues: [this.#isovalue],
      moving,
    });
  }

  /** Looks at the picture. */
  look(fewest = 1, most = 5): Promise<unknown> {
    return pause(1000 * this.chance.between(fewest, most));
  }

  async #gesture(seconds: number, move: (share: number) => void): Promise<void> {
    const steps = Math.max(1, Math.round((1000 * seconds) / step));
    for (let i = 0; i < steps; ++i) {
      move(1 / steps);
      this.#show(true);
      await pause(step);
    }
    this.#show(false);
  }

  /** Drags the volume, by this many degrees at most. */
  turn(degrees: number): Promise<void> {
    const right = this.chance.between(-degrees, degrees);
    const up = this.chance.between(-degrees / 4, degrees / 4);
    return this.#gesture(this.chance.between(0.4, 1.5), (share) =>
      this.#camera.orbit(share * right, share * up),
    );
  }

  zoom(factor: number): Promise<void> {
    return this.#gesture(this.chance.between(0.5, 1.5), (share) =>
      this.#camera.zoom(factor ** share),
    );
  }

  /** Shifts the picture, by this share of its height at most. */
  pan(heights: number): Promise<void> {
    const right = this.chance.between(-heights, heights);
    const down = this.chance.between(-heights, heights);
    return this.#gesture(this.chance.between(0.3, 1), (share) =>
      this.#camera.pan(share * right, share * down),
    );
  }

  /** An isovalue of interest: a suggested one, or up to a third of the range beside it. */
  #otherIsovalue(): number {
    const { range, metadata } = this.#session.info;
    const around = this.chance.of(metadata.suggested_isovalues ?? [this.#isovalue]);
    const shift = this.chance.next() < 0.3 ? 0 : this.chance.between(-1, 1) ** 3 / 3;
    const value = around + shift * (range[1] - range[0]);
    return Math.min(range[1], Math.max(range[0], value));
  }

  /** Drags the slider. */
  slide(): Promise<void> {
    const way = this.#otherIsovalue() - this.#isovalue;
    return this.#gesture(this.chance.between(0.5, 2.5), (share) => {
      this.#isovalue += share * way;
    });
  }

  /** Types an isovalue, or clicks on one. */
  async choose(): Promise<void> {
    this.#isovalue = this.#otherIsovalue();
    this.#show(false);
  }
}

export type Script = (visitor: ScriptedVisitor) => Promise<unknown>;

/** What visitors do after they have opened a volume. */
export const scripts: Record<string, Script> = {
  async look(visitor) {
    await visitor.look(4, 10);
  },
  async turn(visitor) {
    await visitor.look(2, 5);
    for (let i = visitor.chance.whole(2, 5); i > 0; --i) {
      await visitor.turn(150);
      await visitor.look();
    }
  },
  async zoom(visitor) {
    await visitor.look(2, 5);
    await visitor.pan(0.25);
    const factor = visitor.chance.between(2, 8);
    await visitor.zoom(1 / factor);
    await visitor.look(2, 6);
    await visitor.turn(60);
    await visitor.look();
    await visitor.zoom(factor);
    await visitor.look();
  },
  async isovalue(visitor) {
    await visitor.look(2, 5);
    for (let i = visitor.chance.whole(2, 4); i > 0; --i) {
      await visitor.slide();
      await visitor.look();
      await visitor.choose();
      await visitor.look();
    }
  },
  async details(visitor) {
    await visitor.look(2, 5);
    await visitor.pan(0.25);
    await visitor.zoom(1 / visitor.chance.between(5, 15));
    await visitor.look(2, 6);
    for (let i = visitor.chance.whole(1, 3); i > 0; --i) {
      await visitor.pan(0.8);
      await visitor.look();
      await visitor.turn(40);
      await visitor.look();
    }
    await visitor.slide();
    await visitor.look();
  },
};
