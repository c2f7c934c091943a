import type { Viewer } from "../viewer/index.ts";

/**
 * Where an element shows its picture: the canvas, or the last picture while the element has no WebGL
 * context. Without a canvas it takes the focus, and so the element gets a context.
 */
export class PictureArea {
  readonly element = document.createElement("div");
  readonly #label: () => string;

  /** label: what the picture is called for those who cannot see it. */
  constructor(label: () => string) {
    this.element.className = "picture";
    this.#label = label;
  }

  setFocusable(isFocusable: boolean): void {
    const attributes = { tabindex: "0", role: "button", "aria-label": this.#label() };
    for (const [name, value] of Object.entries(attributes)) {
      if (isFocusable) this.element.setAttribute(name, value);
      else this.element.removeAttribute(name);
    }
  }

  /** Adds a canvas above the still picture, which stays until the canvas has drawn. */
  addCanvas(hasFocus: boolean): HTMLCanvasElement {
    const canvas = document.createElement("canvas");
    canvas.tabIndex = 0;
    canvas.setAttribute("part", "canvas");
    canvas.setAttribute("role", "application");
    canvas.setAttribute("aria-roledescription", "3D view");
    canvas.setAttribute("aria-label", this.#label());
    this.element.append(canvas);
    if (hasFocus) canvas.focus({ preventScroll: true });
    this.setFocusable(false);
    return canvas;
  }

  /** Shows a picture in place of the canvas. */
  setStill(still: HTMLImageElement): void {
    this.removeStill();
    this.element.append(still);
  }

  removeStill(): void {
    const still = this.element.querySelector("img");
    if (!still) return;
    URL.revokeObjectURL(still.src);
    still.remove();
  }
}

/** The present picture of a viewer; null if there is none. */
export async function stillOf(viewer: Viewer): Promise<HTMLImageElement | null> {
  const still = document.createElement("img");
  still.alt = "";
  try {
    still.src = URL.createObjectURL(await viewer.screenshot({ smooth: false }));
    await still.decode();
    return still;
  } catch {
    URL.revokeObjectURL(still.src);
    return null;
  }
}
