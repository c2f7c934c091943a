import { html, nothing, render, svg, type TemplateResult } from "lit";
import { LayerDrawing } from "../overlay/layer_drawing.ts";
import { type Screen, type ScreenPoint, screenOf } from "../overlay/screen.ts";
import { mostDrift } from "../viewer/clicks.ts";
import type { Viewer } from "../viewer/viewer.ts";
import { labelPlace } from "./label_place.ts";
import type { MeasureTool, PointPlace } from "./measure_tool.ts";
import { labelPoint, type Measurement } from "./measurement.ts";

/** The size of the font of labels (px). */
const letter = 13;

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
    this.element.addEventListener("pointerdown", (event) => this.#grab(event));
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
    const { shown, draft, kind } = this.#tool;
    render(
      html`<svg class="measure-marks" aria-hidden="true">
        ${shown.map((each, i) => this.#mark(screen, each, "", i))}
        ${draft.length > 0 && kind ? this.#mark(screen, { kind, points: draft }, "draft") : nothing}
        ${kind ? centreMark(screen.width / 2, screen.height / 2) : nothing}
      </svg>
      ${this.#bar()}`,
      this.element,
    );
  }

  /** Follows the pointer that has grabbed a point. A click on a point is one on the surface. */
  #grab(event: PointerEvent): void {
    const handle = (event.target as Element).closest<SVGElement>("[data-place]");
    if (!handle || event.button !== 0) return;
    const [measurement = 0, point = 0] = (handle.dataset.place ?? "").split(" ").map(Number);
    const place: PointPlace = { measurement, point };
    event.preventDefault();
    const listening = new AbortController();
    const { signal } = listening;
    const { left, top } = this.#viewer.canvas.getBoundingClientRect();
    let isMoved = false;
    const end = (keep: boolean) => {
      listening.abort();
      if (isMoved) this.#tool.drop(keep);
      else if (keep) this.#tool.pick(event.clientX - left, event.clientY - top);
      this.#drawing.request();
    };
    const isSame = ({ pointerId }: PointerEvent) => pointerId === event.pointerId;
    const moved = (now: PointerEvent) => {
      if (!isSame(now)) return;
      const distance = Math.hypot(now.clientX - event.clientX, now.clientY - event.clientY);
      isMoved ||= distance > mostDrift;
      if (!isMoved) return;
      this.#tool.move(place, now.clientX - left, now.clientY - top);
      this.#drawing.request();
    };
    window.addEventListener("pointermove", moved, { signal });
    window.addEventListener("pointerup", (now) => isSame(now) && end(true), { signal });
    window.addEventListener("pointercancel", (now) => isSame(now) && end(false), { signal });
    window.addEventListener("keydown", ({ key }) => key === "Escape" && end(false), { signal });
  }

  /** index: of a finished measurement, whose points can be moved. */
  #mark(
    screen: Screen,
    measurement: Measurement,
    className: string,
    index?: number,
  ): TemplateResult {
    const { points } = measurement;
    const positions = points.map(({ position }) => screen.point(position));
    const line = positions.every(isVisible)
      ? positions.map(({ x, y }) => `${x},${y}`).join(" ")
      : "";
    const at = labelPoint(measurement);
    const last = at && screen.point(at);
    return svg`<g class=${className}>
      ${line && points.length > 1 ? svg`<polyline points=${line} />` : nothing}
      ${positions.map((position, i) => (position ? point(position, index, i) : nothing))}
      ${
        last && className !== "draft"
          ? label(this.#label(measurement), last, positions.filter(isVisible))
          : nothing
      }
    </g>`;
  }
}

/** The text beside a measurement. */
function label(text: string, at: ScreenPoint, points: readonly ScreenPoint[]): TemplateResult {
  const { x, y, anchor } = labelPlace(text, at, points, letter);
  return svg`<text x=${x} y=${y} text-anchor=${anchor}>${text}</text>`;
}

/** The point itself, and what can be grabbed around it. */
function point({ x, y }: ScreenPoint, measurement: number | undefined, i: number): TemplateResult {
  return svg`<circle cx=${x} cy=${y} r="4" />${
    measurement === undefined
      ? nothing
      : svg`<circle class="measure-handle" data-place=${`${measurement} ${i}`} cx=${x} cy=${y} />`
  }`;
}

function isVisible(position: ScreenPoint | undefined): position is ScreenPoint {
  return position !== undefined;
}

/** The position that Enter measures. */
function centreMark(x: number, y: number): TemplateResult {
  return svg`<path class="measure-centre" d=${`M${x - 7} ${y}h14M${x} ${y - 7}v14`} />`;
}
