import { onPixelRatio } from "./pixel_ratio.ts";

/**
 * Keeps the pixels of a canvas in step with its size on the page. The size is what the browser has
 * last told of it: to ask for it in a frame would have the page laid out at once.
 */
export class CanvasSize {
  readonly #canvas: HTMLCanvasElement;
  readonly #maxPixelRatio: number;
  readonly #observer: ResizeObserver;
  readonly #unwatch: () => void;
  #cssWidth = 0;
  #cssHeight = 0;

  /** `changed`: the size on the page, or the pixels that it has, are others. */
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

  /** At least 1; CSS pixels. */
  get cssHeight(): number {
    if (this.#cssHeight === 0) this.#read();
    return Math.max(this.#cssHeight, 1);
  }

  /** Width / height. */
  get aspect(): number {
    const { cssHeight } = this;
    return Math.max(this.#cssWidth, 1) / cssHeight;
  }

  /** Answers whether the canvas has another size now, and with that is empty. */
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
