import type { Time } from "../../viewer/time.ts";
import { nearestStep } from "../../viewer/time_order.ts";
import type { Viewer } from "../../viewer/viewer.ts";
import { loadPart } from "../shell/load_part.ts";
import type { TimeBar } from "./time_bar.ts";

/** The functions that time needs from its page. */
export interface PageTimeHost {
  /** Another step is shown at rest. */
  changed(): void;
  render(): void;
}

/** The steps of the page's scene: in its address, by keys, and in a bar, which is loaded at first use. */
export class PageTime {
  readonly #viewer: Viewer;
  readonly #host: PageTimeHost;
  /** The value in the address; undefined after the scene was opened. */
  #ofAddress: number | undefined;
  /** The step that the scene shows first. */
  #first = 0;
  #bar: TimeBar | null = null;

  constructor(viewer: Viewer, ofAddress: number | undefined, host: PageTimeHost) {
    this.#viewer = viewer;
    this.#host = host;
    this.#ofAddress = ofAddress;
    viewer.on("time", (time) => void this.#changed(time));
    // Costs become known when stores are open.
    viewer.on("busy", (isBusy) => !isBusy && this.#bar?.request());
  }

  /** The bar below the picture; null without steps. */
  get element(): HTMLElement | null {
    return this.#bar?.element ?? null;
  }

  /** The value of the step that is shown. Undefined if the scene shows this step first, or has no steps. */
  get value(): number | undefined {
    const { time } = this.#viewer;
    if (!time) return this.#ofAddress;
    return time.wantedStep === this.#first ? undefined : time.values[time.wantedStep];
  }

  /** Shows the step of an earlier view, for undo and redo. */
  restore(value: number | undefined): void {
    const { time } = this.#viewer;
    time?.pause();
    void time?.setStep(value === undefined ? this.#first : nearestStep(time.values, value));
  }

  step(by: 1 | -1): void {
    this.#bar?.step(by);
  }

  togglePlay(): void {
    this.#bar?.togglePlay();
  }

  async #changed(time: Time | null): Promise<void> {
    this.#bar?.close();
    this.#bar = null;
    this.#host.render();
    if (!time) return;
    this.#first = time.step;
    // No layer has been added yet: its first step is this one.
    if (this.#ofAddress !== undefined) {
      void time.setStep(nearestStep(time.values, this.#ofAddress));
      this.#ofAddress = undefined;
    }
    time.on("step", () => !time.isPlaying && this.#host.changed());
    time.on("play", (isPlaying) => !isPlaying && this.#host.changed());
    const { TimeBar } = await loadPart(() => import("./time_bar.ts"));
    if (time !== this.#viewer.time) return;
    this.#bar = new TimeBar(time);
    this.#host.render();
  }
}
