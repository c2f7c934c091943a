import type { Viewer } from "../viewer/viewer.ts";

/**
 * Decides when a layer over the picture of a viewer is drawn: in the frame after a request, and when the
 * camera, the volume or the size of the layer has changed.
 */
export class LayerDrawing {
  readonly #draw: () => void;
  readonly #cleanup: readonly (() => void)[];
  #handle = 0;

  constructor(viewer: Viewer, element: HTMLElement, draw: () => void) {
    this.#draw = draw;
    const size = new ResizeObserver(() => this.request());
    size.observe(element);
    this.#cleanup = [
      viewer.on("camera", () => this.request()),
      viewer.on("opened", () => this.request()),
      () => size.disconnect(),
    ];
  }

  request(): void {
    if (this.#handle !== 0) return;
    this.#handle = requestAnimationFrame(() => {
      this.#handle = 0;
      this.#draw();
    });
  }

  /** Stops following the viewer; what has been drawn stays. */
  stop(): void {
    cancelAnimationFrame(this.#handle);
    for (const clean of this.#cleanup) clean();
  }
}
