/** Chunks that only slices show are drawn after this time (ms), together. */
const collectedMs = 500;

/**
 * Draws slices again after chunks have come or gone. Slices show chunks that the view does not: such as
 * those that are fetched for other isovalues.
 */
export class SliceArrivals {
  readonly #draw: () => void;
  readonly #busyChanged: () => void;
  #timer = 0;

  /** draw: the picture is to be drawn; a view at rest stays as fine as it is. */
  constructor(draw: () => void, busyChanged: () => void) {
    this.#draw = draw;
    this.#busyChanged = busyChanged;
  }

  /** Chunks wait to be drawn. */
  get isBusy(): boolean {
    return this.#timer !== 0;
  }

  /** A chunk has come or gone while slices are shown. */
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
