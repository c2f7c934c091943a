import { type ElementTexts, elementTexts } from "../texts/element.ts";
import type { Viewer } from "../viewer/viewer.ts";

/**
 * The area of an element's picture: the canvas, or the last picture while the element has no WebGL
 * context. Without a canvas the area itself can take the focus, so that the element then gets a
 * context.
 */
export class PictureArea {
  readonly element = document.createElement("div");
  readonly #label: () => string | null;
  #texts = elementTexts;

  /** label: the name of the picture for assistive technology; default: a text of the element. */
  constructor(label: () => string | null) {
    this.element.className = "picture";
    this.#label = label;
  }

  translate(texts: ElementTexts): void {
    this.#texts = texts;
    if (this.element.hasAttribute("tabindex")) this.setFocusable(true);
    const canvas = this.element.querySelector("canvas");
    if (canvas) this.#name(canvas);
  }

  #name(canvas: HTMLCanvasElement): void {
    canvas.setAttribute("aria-roledescription", this.#texts.view3d);
    canvas.setAttribute("aria-label", this.#label() ?? this.#texts.isosurface);
  }

  setFocusable(isFocusable: boolean): void {
    const attributes = {
      tabindex: "0",
      role: "button",
      "aria-label": this.#label() ?? this.#texts.isosurface,
    };
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
    this.#name(canvas);
    this.element.append(canvas);
    if (hasFocus) canvas.focus({ preventScroll: true });
    this.setFocusable(false);
    return canvas;
  }

  /** Shows a picture instead of the canvas. */
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
