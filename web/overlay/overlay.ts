import { html, nothing, render, svg, type TemplateResult } from "lit";
import type { StoreInfo, Triple } from "../stream/index.ts";
import { type AxisView, axisViews, type Viewer } from "../viewer/index.ts";
import { axisNames, viewName } from "./axis_names.ts";
import { boundingBox } from "./bounding_box.ts";
import { formatLength, scaleBar } from "./lengths.ts";
import type { OverlayPart } from "./parts.ts";
import { Screen } from "./screen.ts";

/** Half the width of the square of the axes, and the length of an axis in it, in CSS pixels. */
const axesHalf = 46;
const axisLength = 30;
const longestBar = 140;
const colours = ["#c8423a", "#3f8f3f", "#3d6fd0"] as const;

/**
 * Orientation axes, a scale bar, and the volume's box with ticks, above the picture of a viewer. The
 * element is to lie exactly on the canvas; it takes no pointer events but on the ends of the axes.
 */
export class Overlay {
  readonly element = document.createElement("div");
  readonly #viewer: Viewer;
  readonly #look: (view: AxisView) => void;
  #parts: ReadonlySet<OverlayPart> = new Set();
  #handle = 0;
  readonly #cleanup: (() => void)[];

  /** look: called when the visitor chooses a view along an axis. */
  constructor(viewer: Viewer, look: (view: AxisView) => void) {
    this.#viewer = viewer;
    this.#look = look;
    this.element.className = "overlay";
    const size = new ResizeObserver(() => this.#request());
    size.observe(this.element);
    this.#cleanup = [
      viewer.on("camera", () => this.#request()),
      viewer.on("opened", () => this.#request()),
      () => size.disconnect(),
    ];
  }

  show(parts: ReadonlySet<OverlayPart>): void {
    this.#parts = parts;
    this.#request();
  }

  stop(): void {
    cancelAnimationFrame(this.#handle);
    for (const clean of this.#cleanup) clean();
    this.element.remove();
  }

  #request(): void {
    if (this.#handle === 0) {
      this.#handle = requestAnimationFrame(() => {
        this.#handle = 0;
        this.#draw();
      });
    }
  }

  #draw(): void {
    const { camera, info } = this.#viewer;
    const { clientWidth: width, clientHeight: height } = this.element;
    const matrix = this.#viewer.viewProjection(width, height);
    if (!camera || !info || !matrix || width === 0 || height === 0) {
      render(nothing, this.element);
      return;
    }
    const screen = new Screen(matrix, width, height);
    const has = (part: OverlayPart) => this.#parts.has(part);
    render(
      html`${has("box") ? boxPart(info, screen) : nothing}
      ${has("axes") ? axesPart(info, screen, this.#look) : nothing}
      ${has("scale") ? scalePart(screen, camera.target) : nothing}`,
      this.element,
    );
  }
}

function boxPart(info: StoreInfo, screen: Screen): TemplateResult | typeof nothing {
  const box = boundingBox(info, screen);
  if (!box) return nothing;
  return html`<svg class="overlay-box" aria-hidden="true">
    ${box.edges.map(
      ({ from, to, isBehind }) =>
        svg`<line class=${isBehind ? "behind" : ""} x1=${from.x} y1=${from.y} x2=${to.x} y2=${to.y} />`,
    )}
    ${box.ticks.map(({ at, length, outwards: { x, y } }) => {
      const anchor = Math.abs(x) < 0.4 ? "middle" : x < 0 ? "end" : "start";
      return svg`<line x1=${at.x} y1=${at.y} x2=${at.x + 5 * x} y2=${at.y + 5 * y} />
        <text x=${at.x + 9 * x} y=${at.y + 11 * y} text-anchor=${anchor}
          dominant-baseline="middle">${Number(length.toPrecision(6))}</text>`;
    })}
  </svg>`;
}

function axesPart(info: StoreInfo, screen: Screen, look: (view: AxisView) => void): TemplateResult {
  const names = axisNames(info);
  const ends = axisViews
    .map((view) => {
      const world: Triple = [0, 0, 0];
      world[view.axis] = view.side;
      const { right, down, away } = screen.direction(world);
      const name = names[view.axis]?.[view.side < 0 ? 0 : 1] ?? "";
      return { view, name, x: axisLength * right, y: axisLength * down, away };
    })
    // Ends that point to the eye are drawn last, above the others.
    .sort((a, b) => b.away - a.away);
  return html`<svg
    class="overlay-axes"
    viewBox="${-axesHalf} ${-axesHalf} ${2 * axesHalf} ${2 * axesHalf}"
    role="group"
    aria-label="Orientation"
  >
    ${ends.map(({ view, name, x, y }) => {
      const colour = colours[view.axis];
      const isPositive = view.side > 0;
      return svg`<g class="overlay-axis" role="button" aria-label=${viewName(name)}
          style=${`--axis:${colour}`} @click=${() => look(view)}>
        <title>${viewName(name)}</title>
        ${isPositive ? svg`<line x1="0" y1="0" x2=${x} y2=${y} />` : nothing}
        <circle class=${isPositive ? "" : "negative"} cx=${x} cy=${y} r="9" />
        <text x=${x} y=${y} text-anchor="middle" dominant-baseline="central">${name}</text>
      </g>`;
    })}
  </svg>`;
}

function scalePart(screen: Screen, target: Triple): TemplateResult | typeof nothing {
  const bar = scaleBar(screen.pixelsPerUnit(target), longestBar);
  if (!bar) return nothing;
  const text = formatLength(bar.mm);
  return html`<div
    class="overlay-scale"
    role="img"
    aria-label=${`Scale: the bar is ${text} long`}
    title="At the distance of the centre of rotation"
  >
    <div class="overlay-scale-bar" style=${`width:${bar.pixels}px`}></div>
    ${text}
  </div>`;
}
