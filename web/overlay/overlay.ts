import { type OverlayTexts, overlayTexts } from "../texts/overlay.ts";
import type { AxisView } from "../viewer/camera_views.ts";
import type { Viewer } from "../viewer/viewer.ts";
import { AxesPart } from "./axes_part.ts";
import { BoxPart } from "./box_part.ts";
import { LayerDrawing } from "./layer_drawing.ts";
import type { OverlayPart } from "./parts.ts";
import { ScalePart } from "./scale_part.ts";
import { screenOf } from "./screen.ts";
import { layerElement } from "./shapes.ts";
import { overlayStyles } from "./styles.ts";

/**
 * Orientation axes, a scale bar, and the volume's box with ticks, over the picture of a viewer. The
 * element must cover exactly the canvas. It takes pointer events only on the ends of the axes.
 */
export class Overlay {
  readonly element: HTMLElement;
  readonly #root: ShadowRoot;
  readonly #viewer: Viewer;
  readonly #box = new BoxPart();
  readonly #axes: AxesPart;
  readonly #scale: ScalePart;
  #parts: ReadonlySet<OverlayPart> = new Set();
  readonly #drawing: LayerDrawing;

  /** look: called when the visitor chooses a view along an axis. */
  constructor(viewer: Viewer, look: (view: AxisView) => void, texts: OverlayTexts = overlayTexts) {
    this.#viewer = viewer;
    this.#axes = new AxesPart(look, texts);
    this.#scale = new ScalePart(texts);
    ({ element: this.element, root: this.#root } = layerElement(overlayStyles));
    this.#drawing = new LayerDrawing(viewer, this.element, () => this.#draw());
  }

  show(parts: ReadonlySet<OverlayPart>): void {
    if (parts === this.#parts) return;
    this.#parts = parts;
    this.#drawing.request();
  }

  /** Stops following the viewer; the element stays as it is. */
  stop(): void {
    this.#drawing.stop();
  }

  #draw(): void {
    const { camera, info } = this.#viewer;
    const screen = screenOf(this.#viewer, this.element);
    const shown: Element[] = [];
    if (camera && info && screen) {
      if (this.#parts.has("box")) {
        this.#box.draw(info, screen);
        shown.push(this.#box.element);
      }
      if (this.#parts.has("axes")) {
        this.#axes.draw(info, screen);
        shown.push(this.#axes.element);
      }
      if (this.#parts.has("scale")) {
        this.#scale.draw(info, screen, camera.target);
        shown.push(this.#scale.element);
      }
    }
    const { children } = this.#root;
    if (shown.length !== children.length || shown.some((part, i) => part !== children[i])) {
      this.#root.replaceChildren(...shown);
    }
  }
}
