/**
 * While the isovalue changes repeatedly, the page is laid out at this interval (ms). Laying it out takes longer
 * than all else that a change of the isovalue needs beside drawing.
 */
export const followInterval = 120;

/**
 * Decides when the page is laid out: in the next frame. Changes of the isovalue alone, as by a slider, are shown
 * in the next frame where the visitor looks; all else follows at most every `followInterval`.
 */
export class LayoutPace {
  readonly #layOut: () => void;
  readonly #showIsovalue: () => void;
  #handle = 0;
  #timer: ReturnType<typeof setTimeout> | undefined;
  /** Whether something else than the isovalue has changed. */
  #isOther = false;
  #laidOutAt = Number.NEGATIVE_INFINITY;

  /** layOut: must call `laidOut`. showIsovalue: shows the isovalue, and nothing else. */
  constructor(layOut: () => void, showIsovalue: () => void) {
    this.#layOut = layOut;
    this.#showIsovalue = showIsovalue;
  }

  /** `isIsovalueOnly`: nothing but the isovalue of the active surface has changed. */
  request(isIsovalueOnly = false): void {
    if (!isIsovalueOnly) this.#isOther = true;
    if (this.#handle === 0) this.#handle = requestAnimationFrame(() => this.#frame());
  }

  /** The page was laid out. */
  laidOut(): void {
    cancelAnimationFrame(this.#handle);
    clearTimeout(this.#timer);
    this.#handle = 0;
    this.#timer = undefined;
    this.#isOther = false;
    this.#laidOutAt = performance.now();
  }

  #frame(): void {
    this.#handle = 0;
    const wait = this.#laidOutAt + followInterval - performance.now();
    if (this.#isOther || wait <= 0) {
      this.#layOut();
      return;
    }
    this.#showIsovalue();
    this.#timer ??= setTimeout(() => this.request(), wait);
  }
}
