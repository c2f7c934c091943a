import { onPixelRatio } from "./pixel_ratio.ts";

/**
 * Adapts the pixels of a canvas to its size on the page. Uses the size that the browser reported
 * last (ResizeObserver): reading it within a frame would force a layout of the page.
 */
export class CanvasSize {
  readonly #canvas: HTMLCanvasElement;
  readonly #maxPixelRatio: number;
  readonly #observer: ResizeObserver;
  readonly #unwatch: () => void;
  #cssWidth = 0;
  #cssHeight = 0;

  /** changed: called when the size on the page or the number of pixels has changed. */
  constructor(canvas: HTMLCanvasElement, maxPixelRatio: number, changed: () => void) {
    this.#canvas = canvas;
    this.#maxPixelRatio = maxPixelRatio;
    this.#observer = new ResizeObserver(() => {
      this.#read();
      changed();
    });
    this.#observer.observe(canvas);
    this.#unwatch = onPixelRatio(changed);
  }

  /** In CSS pixels, at least 1. */
  get cssHeight(): number {
    if (this.#cssHeight === 0) this.#read();
    return Math.max(this.#cssHeight, 1);
  }

  /** Width / height. */
  get aspect(): number {
    const { cssHeight } = this;
    return Math.max(this.#cssWidth, 1) / cssHeight;
  }

  /** Returns whether it resized the canvas, which also clears it. */
  fit(): boolean {
    const ratio = Math.min(devicePixelRatio, this.#maxPixelRatio);
    const height = Math.max(1, Math.round(this.cssHeight * ratio));
    const width = Math.max(1, Math.round(this.#cssWidth * ratio));
    if (this.#canvas.width === width && this.#canvas.height === height) return false;
    this.#canvas.width = width;
    this.#canvas.height = height;
    return true;
  }

  #read(): void {
    this.#cssWidth = this.#canvas.clientWidth;
    this.#cssHeight = this.#canvas.clientHeight;
  }

  stop(): void {
    this.#observer.disconnect();
    this.#unwatch();
  }
}
