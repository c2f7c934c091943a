/** Chunks that only slices show are drawn together after this time (ms). */
const collectedMs = 500;

/**
 * Draws slices again after chunks were added or removed. Slices also show chunks that the view does
 * not need, such as those that are fetched for other isovalues.
 */
export class SliceArrivals {
  readonly #draw: () => void;
  readonly #busyChanged: () => void;
  #timer = 0;

  /** draw: draws the picture again; a view at rest keeps its quality. */
  constructor(draw: () => void, busyChanged: () => void) {
    this.#draw = draw;
    this.#busyChanged = busyChanged;
  }

  /** Whether chunks wait to be drawn. */
  get isBusy(): boolean {
    return this.#timer !== 0;
  }

  /** A chunk was added or removed while slices are shown. */
  changed(): void {
    if (this.#timer !== 0) return;
    this.#timer = window.setTimeout(() => {
      this.#timer = 0;
      this.#draw();
      this.#busyChanged();
    }, collectedMs);
    this.#busyChanged();
  }

  stop(): void {
    clearTimeout(this.#timer);
    this.#timer = 0;
  }
}
