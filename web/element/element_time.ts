import { defaultMode, defaultRate, maxRate, type Time } from "../viewer/time.ts";
import { nearestStep, type PlayMode, playModes } from "../viewer/time_order.ts";
import type { Viewer } from "../viewer/viewer.ts";

/** The functions that the time of an element needs from its view. */
export interface ElementTimeHost {
  /** Null while the element has no WebGL context. */
  viewer(): Viewer | null;
  /** Requests a draw. */
  wake(): void;
  /** Called when the values that the controls show have changed. */
  shown(time: Time | null): void;
  /** Another step is shown. `value`: its time, for the group; undefined if the group has chosen it. */
  changed(step: number, value: number | undefined): void;
}

/** A step, or the value of the step that is nearest to it. */
type Wanted = { step: number } | { value: number };

/**
 * The step of an element's scene. Keeps it even without a viewer. A group shares the value of the step, not
 * its number: scenes with different steps show the same time.
 */
export class ElementTime {
  readonly #host: ElementTimeHost;
  /** The step that is shown, or that the next scene begins with. */
  #wanted: Wanted = { step: 0 };
  /** The values of the open scene's steps; null before one is open. */
  #values: readonly number[] | null = null;
  /** The step that the group has chosen last. */
  #received: number | null = null;
  /** Whether the step is not the default of the scene. */
  #isChosen = false;
  #rate = defaultRate;
  #mode = defaultMode;

  constructor(host: ElementTimeHost) {
    this.#host = host;
  }

  /** Follows a new viewer. */
  attach(viewer: Viewer): void {
    viewer.on("time", (time) => {
      if (time) [time.rate, time.mode] = [this.#rate, this.#mode];
      this.#host.shown(time);
      if (!time) return;
      this.#values = time.values;
      this.#wanted = { step: time.step };
      // A program may change them, too.
      time.on("change", () => {
        this.#rate = time.rate;
        this.#mode = time.mode;
      });
      for (const name of ["step", "play", "change"] as const) {
        time.on(name, () => this.#host.shown(time));
      }
      time.on("step", (step) => {
        this.#wanted = { step };
        this.#isChosen = true;
        const isReceived = step === this.#received && !time.isPlaying;
        this.#host.changed(step, isReceived ? undefined : time.values[step]);
      });
    });
  }

  /** The step with which a scene of these values is opened; undefined: that of the scene. */
  firstOf(values: readonly number[]): number | undefined {
    const wanted = this.#wanted;
    if ("step" in wanted && !this.#isChosen) return undefined;
    return "step" in wanted ? wanted.step : nearestStep(values, wanted.value);
  }

  /** The number of the step that is shown, or will be as soon as it has a surface. */
  get step(): number {
    const time = this.#host.viewer()?.time;
    if (time) return time.wantedStep;
    return "step" in this.#wanted ? this.#wanted.step : 0;
  }

  /** The value of a step that was chosen; undefined for the default, and before a scene with time is open. */
  get chosenValue(): number | undefined {
    return this.#isChosen ? this.#values?.[this.step] : undefined;
  }

  /** Numbers beyond the last step mean the last one. */
  set step(requested: number) {
    if (Number.isNaN(requested)) return;
    this.#received = null;
    this.#isChosen = true;
    this.#show(this.#limited(requested));
  }

  /** Time.rate, of this scene and of those that follow. Throws a RangeError. */
  get rate(): number {
    return this.#rate;
  }

  set rate(rate: number) {
    if (!(rate > 0 && rate <= maxRate)) {
      throw new RangeError(`expected a rate above 0 and at most ${maxRate}, found ${rate}`);
    }
    this.#rate = rate;
    const time = this.#host.viewer()?.time;
    if (time) time.rate = rate;
  }

  /** Time.mode, of this scene and of those that follow. Throws a RangeError. */
  get mode(): PlayMode {
    return this.#mode;
  }

  set mode(mode: PlayMode) {
    if (!playModes.includes(mode)) {
      throw new RangeError(`expected one of ${playModes.join(", ")}, found ${mode}`);
    }
    this.#mode = mode;
    const time = this.#host.viewer()?.time;
    if (time) time.mode = mode;
  }

  /** Plays the scene, or stops it. */
  togglePlay(): void {
    this.#host.wake();
    const time = this.#host.viewer()?.time;
    if (time?.isPlaying) time.pause();
    else time?.play();
  }

  /** The group has this time. */
  receive(value: number): void {
    if (!this.#values) {
      this.#wanted = { value };
      return;
    }
    const step = nearestStep(this.#values, value);
    this.#received = step;
    this.#show(step);
  }

  /** Another scene begins with the step of the attribute. */
  reset(step: number | undefined): void {
    this.#values = null;
    this.#received = null;
    this.#isChosen = step !== undefined;
    this.#wanted = { step: step ?? 0 };
  }

  #limited(step: number): number {
    const last = this.#values ? this.#values.length - 1 : Number.POSITIVE_INFINITY;
    return Math.min(Math.max(0, Math.trunc(step)), last);
  }

  #show(step: number): void {
    const time = this.#host.viewer()?.time;
    if (time) {
      void time.setStep(step);
    } else if (step !== this.step || !("step" in this.#wanted)) {
      this.#wanted = { step };
      const value = step === this.#received ? undefined : this.#values?.[step];
      if (this.#values) this.#host.changed(step, value);
    }
    this.#host.wake();
  }
}
