import { html, nothing, render, svg, type TemplateResult } from "lit";
import { LayerDrawing } from "../overlay/layer_drawing.ts";
import { type Screen, type ScreenPoint, screenOf } from "../overlay/screen.ts";
import type { Viewer } from "../viewer/viewer.ts";
import type { MeasureTool } from "./measure_tool.ts";
import { labelPoint, type Measurement } from "./measurement.ts";

/** Draws measurements over the picture of a viewer. The element must be placed over its canvas. */
export class MeasureLayer {
  readonly element = document.createElement("div");
  readonly #viewer: Viewer;
  readonly #tool: MeasureTool;
  readonly #label: (measurement: Measurement) => string;
  readonly #bar: () => TemplateResult;
  readonly #drawing: LayerDrawing;

  /** label: the text beside a measurement; bar: other content above the picture. */
  constructor(
    viewer: Viewer,
    tool: MeasureTool,
    label: (measurement: Measurement) => string,
    bar: () => TemplateResult,
  ) {
    this.#bar = bar;
    this.#viewer = viewer;
    this.#tool = tool;
    this.#label = label;
    this.element.className = "overlay measure-layer";
    this.#drawing = new LayerDrawing(viewer, this.element, () => this.#draw());
  }

  stop(): void {
    this.#drawing.stop();
    this.element.remove();
  }

  /** Draws in the next frame. */
  request(): void {
    this.#drawing.request();
  }

  #draw(): void {
    const screen = screenOf(this.#viewer, this.element);
    if (!screen) {
      render(nothing, this.element);
      return;
    }
    const { measurements, draft, kind } = this.#tool;
    render(
      html`<svg class="measure-marks" aria-hidden="true">
        ${measurements.map((each) => this.#mark(screen, each, ""))}
        ${draft.length > 0 && kind ? this.#mark(screen, { kind, points: draft }, "draft") : nothing}
        ${kind ? centreMark(screen.width / 2, screen.height / 2) : nothing}
      </svg>
      ${this.#bar()}`,
      this.element,
    );
  }

  #mark(screen: Screen, measurement: Measurement, className: string): TemplateResult {
    const { points } = measurement;
    const positions = points.map(({ position }) => screen.point(position));
    const line = positions.every(isVisible)
      ? positions.map(({ x, y }) => `${x},${y}`).join(" ")
      : "";
    const at = labelPoint(measurement);
    const last = at && screen.point(at);
    return svg`<g class=${className}>
      ${line && points.length > 1 ? svg`<polyline points=${line} />` : nothing}
      ${positions.map((position) => (position ? svg`<circle cx=${position.x} cy=${position.y} r="4" />` : nothing))}
      ${
        last && className !== "draft"
          ? svg`<text x=${last.x + 9} y=${last.y - 7}>${this.#label(measurement)}</text>`
          : nothing
      }
    </g>`;
  }
}

function isVisible(position: ScreenPoint | undefined): position is ScreenPoint {
  return position !== undefined;
}

/** The position that Enter measures. */
function centreMark(x: number, y: number): TemplateResult {
  return svg`<path class="measure-centre" d=${`M${x - 7} ${y}h14M${x} ${y - 7}v14`} />`;
}
