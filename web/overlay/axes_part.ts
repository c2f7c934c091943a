import type { StoreInfo, Triple } from "../core/types.ts";
import type { OverlayTexts } from "../texts/overlay.ts";
import { type AxisView, axisViews } from "../viewer/camera_views.ts";
import { axisColours, axisNames, viewName } from "./axis_names.ts";
import type { Screen } from "./screen.ts";
import { setAttributes, svgElement } from "./shapes.ts";

/** Half the width of the square of the axes, and the length of an axis in it, in CSS pixels. */
const half = 46;
const axisLength = 30;
/** On phones, 92 units are 76 px. */
const hitRadius = 15;

/** An end of an axis: a button that shows the view from there. */
class AxisEnd {
  readonly view: AxisView;
  readonly element = svgElement("g", { class: "overlay-axis", role: "button", tabindex: -1 });
  readonly #title = svgElement("title");
  readonly #line = svgElement("line", { x1: 0, y1: 0 });
  readonly #circle = svgElement("circle", { r: 9 });
  /** What a pointer hits: at least 24 px, also where the axes are drawn smaller. */
  readonly #area = svgElement("circle", { r: hitRadius, class: "area" });
  readonly #text = svgElement("text", {
    "text-anchor": "middle",
    "dominant-baseline": "central",
  });

  readonly #texts: OverlayTexts;

  constructor(view: AxisView, look: (view: AxisView) => void, texts: OverlayTexts) {
    this.view = view;
    this.#texts = texts;
    this.element.style.setProperty("--axis", axisColours[view.axis]);
    this.element.append(this.#title);
    if (view.side > 0) this.element.append(this.#line);
    else this.#circle.setAttribute("class", "negative");
    this.element.append(this.#circle, this.#text, this.#area);
    this.element.addEventListener("click", () => look(view));
  }

  name(name: string): void {
    if (this.#text.textContent === name) return;
    this.#text.textContent = name;
    const view = viewName(name, this.#texts);
    this.#title.textContent = view;
    setAttributes(this.element, { "aria-label": view });
  }

  moveTo(x: number, y: number): void {
    setAttributes(this.#line, { x2: x, y2: y });
    setAttributes(this.#circle, { cx: x, cy: y });
    setAttributes(this.#area, { cx: x, cy: y });
    setAttributes(this.#text, { x, y });
  }
}

/** The world's axes in the present view. */
export class AxesPart {
  readonly element = svgElement("svg", {
    class: "overlay-axes",
    viewBox: `${-half} ${-half} ${2 * half} ${2 * half}`,
    role: "group",
  });
  readonly #ends: readonly AxisEnd[];

  /** look: called when the visitor chooses a view along an axis. */
  constructor(look: (view: AxisView) => void, texts: OverlayTexts) {
    setAttributes(this.element, { "aria-label": texts.orientation });
    this.#ends = axisViews.map((view) => new AxisEnd(view, look, texts));
    this.element.append(...this.#ends.map((end) => end.element));
    this.#ends[0]?.element.setAttribute("tabindex", "0");
    this.element.addEventListener("keydown", (event) => this.#key(event, look));
  }

  draw(info: StoreInfo, screen: Screen): void {
    const names = axisNames(info);
    const seen = this.#ends.map((end) => {
      const { axis, side } = end.view;
      end.name(names[axis]?.[side < 0 ? 0 : 1] ?? "");
      const world: Triple = [0, 0, 0];
      world[axis] = side;
      const { right, down, away } = screen.direction(world);
      end.moveTo(axisLength * right, axisLength * down);
      return { end, away };
    });
    // Ends that point to the eye are drawn above the others. An element that is moved in the document
    // loses the focus.
    const order = seen.sort((a, b) => b.away - a.away).map(({ end }) => end.element);
    if (order.every((element, i) => this.element.children[i] === element)) return;
    const focused = order.find((element) => element.matches(":focus"));
    this.element.append(...order);
    focused?.focus({ preventScroll: true });
  }

  /** The ends form one stop of the Tab key; arrow keys move from end to end. */
  #key(event: KeyboardEvent, look: (view: AxisView) => void): void {
    const at = this.#ends.findIndex(({ element }) => element === event.target);
    const end = this.#ends[at];
    if (!end || event.ctrlKey || event.metaKey || event.altKey) return;
    const steps: Record<string, number> = {
      ArrowRight: 1,
      ArrowDown: 1,
      ArrowLeft: -1,
      ArrowUp: -1,
    };
    const step = steps[event.key];
    if (event.key === "Enter" || event.key === " ") look(end.view);
    else if (step) {
      const next = this.#ends[(at + step + this.#ends.length) % this.#ends.length];
      end.element.setAttribute("tabindex", "-1");
      next?.element.setAttribute("tabindex", "0");
      next?.element.focus({ preventScroll: true });
    } else return;
    event.preventDefault();
    event.stopPropagation();
  }
}
