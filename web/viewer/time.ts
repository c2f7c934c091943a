import { Emitter } from "./emitter.ts";
import type { PlayCost } from "./time_cost.ts";
import { nextPosition, type PlayMode, type PlayPosition } from "./time_order.ts";

/** The steps of a scene that changes with time. */
export interface SceneTime {
  /** The value of each step. They increase. */
  values: readonly number[];
  /** Default: none. */
  unit?: string;
}

export interface TimeEvents {
  /** Another step is shown. */
  step: number;
  /** Playing has begun or ended. */
  play: boolean;
  /** `isBuffering` has changed. */
  buffering: boolean;
  /** Another step is wanted, `rate`, `mode` or `cost` has changed. */
  change: undefined;
}

/** The functions that time needs from the layers. */
export interface TimeHost {
  /** Whether all layers have a surface of this step. Requests what is missing. */
  isShowable(step: number): boolean;
  /** Shows a step of all layers. Returns whether this changes the picture. */
  show(step: number): boolean;
  /** Called when other steps may have to be fetched. */
  changed(): void;
  cost(): PlayCost | undefined;
  cellPixels(): number;
}

/** The largest number of steps per second. */
export const maxRate = 60;
/** Steps per second, and what follows the last step, unless they are set. */
export const defaultRate = 5;
export const defaultMode: PlayMode = "loop";

/**
 * The steps of a viewer's scene. All layers always show the same step. A step is shown as soon as each layer has a
 * surface of it, even if it is coarse; until then, the previous step stays. `play` shows every step in turn, and
 * waits until each has been drawn.
 */
export class Time extends Emitter<TimeEvents> {
  readonly values: readonly number[];
  readonly unit: string;
  readonly #host: TimeHost;
  #position: PlayPosition;
  #wanted: PlayPosition | null = null;
  #isPlaying = false;
  #rate = defaultRate;
  #mode = defaultMode;
  /** When the next step is to be shown (ms). */
  #due = 0;
  #timer: ReturnType<typeof setTimeout> | undefined;
  /** Whether the step that is shown has been drawn. */
  #isDrawn = true;
  #waiting: (() => void)[] = [];

  constructor({ values, unit = "" }: SceneTime, step: number, host: TimeHost) {
    super();
    this.values = [...values];
    this.unit = unit;
    this.#position = { step: this.#checked(step), direction: 1 };
    this.#host = host;
  }

  /** The number of steps. */
  get steps(): number {
    return this.values.length;
  }

  /** The step that is shown. */
  get step(): number {
    return this.#position.step;
  }

  /** The step that is shown next, as soon as it has a surface; otherwise `step`. */
  get wantedStep(): number {
    return this.#wanted?.step ?? this.step;
  }

  /** `wantedStep`, and the direction of the last change. */
  get position(): PlayPosition {
    return this.#wanted ?? this.#position;
  }

  get isPlaying(): boolean {
    return this.#isPlaying;
  }

  /** Whether `wantedStep` waits for its first surface. */
  get isBuffering(): boolean {
    return this.#wanted !== null;
  }

  /** Steps per second while playing, above 0 and at most `maxRate`. Default: 5. */
  get rate(): number {
    return this.#rate;
  }

  set rate(rate: number) {
    if (!(rate > 0 && rate <= maxRate)) {
      throw new RangeError(`a rate is above 0 and at most ${maxRate} steps per second`);
    }
    this.#rate = rate;
    this.#due = Math.min(this.#due, performance.now() + this.#period);
    this.#plan();
    this.#schedule();
  }

  /** What follows the last step while playing. Default: the first one. */
  get mode(): PlayMode {
    return this.#mode;
  }

  set mode(mode: PlayMode) {
    this.#mode = mode;
    this.#plan();
  }

  /** The bytes of all steps at full detail; undefined until those of one step are known. */
  get cost(): PlayCost | undefined {
    return this.#host.cost();
  }

  /**
   * Cells of the steps that play are at most this large, in pixels, so that they play without a stop at the
   * measured bandwidth: 1 at full detail.
   */
  get cellPixels(): number {
    return this.#host.cellPixels();
  }

  /**
   * Shows a step. Resolves when it is shown, or when another one is wanted instead. Throws a RangeError if
   * there is no such step.
   */
  setStep(step: number): Promise<void> {
    this.#checked(step);
    if (step === this.wantedStep) return this.#wanted ? this.#shown() : Promise.resolve();
    const direction = step < this.step ? -1 : 1;
    this.#due = performance.now() + this.#period;
    if (step === this.step) {
      this.#setWanted(null);
      this.#settle();
      return Promise.resolve();
    }
    this.#settle();
    return this.#want({ step, direction }) ? Promise.resolve() : this.#shown();
  }

  /** Plays forwards, beginning with the step after the one that is shown; after the last one, with the first. */
  play(): void {
    if (this.#isPlaying || this.steps < 2) return;
    this.#isPlaying = true;
    this.#position = { step: this.step, direction: 1 };
    this.#due = performance.now() + this.#period;
    this.emit("play", true);
    this.#plan();
    // A scene that has ended begins again.
    if (!nextPosition(this.#position, this.steps, this.#mode))
      this.#want({ step: 0, direction: 1 });
    this.#schedule();
  }

  /** Stops playing. The present step is then refined. */
  pause(): void {
    if (!this.#isPlaying) return;
    this.#isPlaying = false;
    clearTimeout(this.#timer);
    this.#setWanted(null);
    this.#settle();
    this.emit("play", false);
    this.#plan();
  }

  /** Called when a step may have become ready to be shown. */
  arrived(): void {
    const wanted = this.#wanted;
    if (!wanted || !this.#host.isShowable(wanted.step)) return;
    this.#due = performance.now() + this.#period;
    this.#show(wanted);
  }

  /** A frame of the shown step was drawn. */
  drawn(): void {
    this.#isDrawn = true;
    this.#schedule();
  }

  /** Ends playing. No event follows. */
  close(): void {
    this.removeListeners();
    clearTimeout(this.#timer);
    this.#isPlaying = false;
    this.#wanted = null;
    this.#settle();
  }

  get #period(): number {
    return 1000 / this.#rate;
  }

  #checked(step: number): number {
    if (Number.isInteger(step) && step >= 0 && step < this.values.length) return step;
    throw new RangeError(`expected a step from 0 to ${this.values.length - 1}, found ${step}`);
  }

  #shown(): Promise<void> {
    return new Promise((resolve) => this.#waiting.push(resolve));
  }

  #settle(): void {
    for (const resolve of this.#waiting.splice(0)) resolve();
  }

  #plan(): void {
    this.#host.changed();
    this.emit("change", undefined);
  }

  #schedule(): void {
    clearTimeout(this.#timer);
    if (!this.#isPlaying || this.#wanted || !this.#isDrawn) return;
    const wait = Math.max(0, this.#due - performance.now());
    this.#timer = setTimeout(() => this.#next(), wait);
  }

  #next(): void {
    const next = nextPosition(this.#position, this.steps, this.#mode);
    if (!next) {
      this.pause();
      return;
    }
    const now = performance.now();
    // After a delay, the following steps keep their rate instead of catching up.
    const isLate = now - this.#due > this.#period;
    this.#due = (isLate ? now : this.#due) + this.#period;
    this.#want(next);
  }

  /** Returns whether the step is shown already. */
  #want(position: PlayPosition): boolean {
    if (this.#host.isShowable(position.step)) {
      this.#show(position);
      return true;
    }
    this.#setWanted(position);
    this.#plan();
    return false;
  }

  #show(position: PlayPosition): void {
    this.#position = position;
    this.#isDrawn = !this.#host.show(position.step);
    this.#setWanted(null);
    this.#settle();
    this.emit("step", position.step);
    this.#plan();
    this.#schedule();
  }

  #setWanted(wanted: PlayPosition | null): void {
    const wasBuffering = this.isBuffering;
    this.#wanted = wanted;
    if (this.isBuffering !== wasBuffering) this.emit("buffering", this.isBuffering);
  }
}
