import { pageTexts } from "../../texts/page.ts";
import { onPixelRatio } from "../../viewer/pixel_ratio.ts";
import { fraction, type IsovalueScale } from "./isovalue_scale.ts";

/** An isosurface on the histogram. */
export interface HistogramMark {
  value: number;
  colour: string;
  /** Whether the slider changes this isosurface. */
  isActive: boolean;
}

/** Data for bars and ticks. The objects stay the same as long as the data do not change. */
export interface HistogramContent {
  scale: IsovalueScale;
  /** Voxel counts of equal parts of the range from low to high. */
  histogram: { low: number; high: number; counts: readonly number[] } | undefined;
  suggestions: readonly number[];
  /** The number of active cells at the middle of equal parts of the range, for the curve. */
  activeCells: { low: number; high: number; counts: readonly number[] } | undefined;
  /** Whether heights are logarithms of counts: there may be a thousand times more air than bone. */
  isLogarithmic: boolean;
}

export interface HistogramActions {
  /** The visitor clicks or drags to a value. */
  pick(value: number): void;
  /** A drag begins on the mark of this surface. */
  activate(index: number): void;
  /** The wheel was turned: moves the value by this many steps. */
  step(by: number): void;
}

/** A drag that begins within this distance of a mark (CSS pixels) moves the mark. */
const reach = 10;

/** Space above the bars for the marks' heads, CSS pixels. */
const marksHeight = 7;

/**
 * Histogram of the values, with a curve of the active cells of each isovalue, ticks at suggested
 * isovalues, and lines at the isosurfaces, which can be dragged. Bars and ticks are drawn
 * only when they change; moving a mark causes neither layout nor drawing. The element's CSS sets
 * the colours: color for bars, --inside for values inside the active surface, --tick for ticks, --curve for
 * the curve.
 */
export class Histogram {
  readonly element = document.createElement("div");
  readonly #bars = layer("histogram-bars");
  /** A second copy of the bars, clipped at the active isosurface. */
  readonly #inside = layer("histogram-inside");
  readonly #marks: HTMLElement[] = [];
  /** The marks that are shown. */
  #shown: readonly HistogramMark[] = [];
  readonly #actions: HistogramActions;
  #content: HistogramContent | undefined;
  /** CSS pixels; stored to avoid layout queries. */
  #size = { width: 0, height: 0 };

  constructor(actions: HistogramActions) {
    this.#actions = actions;
    this.element.className = "histogram";
    this.element.id = "histogram";
    this.element.setAttribute("role", "img");
    this.element.setAttribute("aria-label", pageTexts.histogram);
    this.element.append(this.#bars, this.#inside);
    this.element.addEventListener("pointerdown", this.#pointer);
    this.element.addEventListener("pointermove", this.#pointer);
    this.element.addEventListener("wheel", this.#wheel, { passive: false });
    new ResizeObserver(([entry]) => {
      if (!entry) return;
      const { width, height } = entry.contentRect;
      this.#size = { width, height };
      this.draw();
    }).observe(this.element);
    onPixelRatio(() => this.draw());
  }

  /** Shows a volume's values and these isosurfaces. */
  show(content: HistogramContent, marks: readonly HistogramMark[]): void {
    const now = this.#content;
    const isSame =
      now?.scale === content.scale &&
      now.histogram === content.histogram &&
      now.activeCells === content.activeCells &&
      now.isLogarithmic === content.isLogarithmic &&
      now.suggestions === content.suggestions;
    this.#content = content;
    if (!isSame) this.draw();
    this.#moveMark(marks, content.scale);
  }

  /** Redraws bars and ticks after a change of the theme. */
  draw(): void {
    const content = this.#content;
    const { width, height } = this.#size;
    if (!content || width === 0 || height === 0) return;
    const style = getComputedStyle(this.element);
    const bars = barsOf(content, width, height);
    const ticks = ticksOf(content, width, height);
    const curve = curveOf(content, width, height);
    const colours: [HTMLCanvasElement, string][] = [
      [this.#bars, style.color],
      [this.#inside, style.getPropertyValue("--inside")],
    ];
    for (const [canvas, colour] of colours) {
      const context = prepared(canvas, width, height);
      if (!context) return;
      context.fillStyle = colour;
      context.fill(bars);
      context.fillStyle = style.getPropertyValue("--tick");
      context.fill(ticks);
      context.strokeStyle = style.getPropertyValue("--curve");
      context.lineWidth = 1.5;
      context.stroke(curve);
    }
  }

  #moveMark(marks: readonly HistogramMark[], scale: IsovalueScale): void {
    const before = this.#shown;
    this.#shown = marks;
    while (this.#marks.length > marks.length) this.#marks.pop()?.remove();
    marks.forEach(({ value, colour, isActive }, i) => {
      const mark = this.#marks[i] ?? this.#addMark();
      const percent = 100 * fraction(value, scale);
      // The mark is as wide as the histogram, so a percentage of its own width moves its left edge
      // to the value.
      mark.style.transform = `translateX(${percent}%)`;
      // Setting a style costs a style recalculation, even if the value is the same.
      if (colour !== before[i]?.colour) mark.style.setProperty("--colour", colour);
      if (isActive !== before[i]?.isActive) mark.classList.toggle("active", isActive);
      if (isActive) this.#inside.style.clipPath = `inset(0 0 0 ${percent}%)`;
    });
  }

  #addMark(): HTMLElement {
    const mark = document.createElement("div");
    mark.className = "histogram-mark";
    this.#marks.push(mark);
    this.element.append(mark);
    return mark;
  }

  readonly #pointer = (event: PointerEvent): void => {
    const { element } = this;
    const scale = this.#content?.scale;
    if (event.type === "pointerdown" && event.button === 0) {
      element.setPointerCapture(event.pointerId);
      const nearest = this.#markAt(event.offsetX);
      if (nearest !== undefined) this.#actions.activate(nearest);
    }
    if (!scale || !element.hasPointerCapture(event.pointerId)) return;
    const share = Math.max(0, Math.min(1, event.offsetX / Math.max(this.#size.width, 1)));
    this.#actions.pick(scale.low + share * (scale.high - scale.low));
  };

  /** The nearest mark within reach of this position. */
  #markAt(x: number): number | undefined {
    const scale = this.#content?.scale;
    if (!scale) return undefined;
    const distances = this.#shown.map(({ value }) =>
      Math.abs(fraction(value, scale) * this.#size.width - x),
    );
    const least = Math.min(...distances);
    return least <= reach ? distances.indexOf(least) : undefined;
  }

  readonly #wheel = (event: WheelEvent): void => {
    // With Ctrl the wheel zooms the page; sideways it scrolls.
    if (event.ctrlKey || event.deltaY === 0) return;
    event.preventDefault();
    this.#actions.step(event.deltaY > 0 ? -1 : 1);
  };
}

function layer(name: string): HTMLCanvasElement {
  const canvas = document.createElement("canvas");
  canvas.className = name;
  return canvas;
}

/** A blank canvas of this size in CSS pixels. */
function prepared(
  canvas: HTMLCanvasElement,
  width: number,
  height: number,
): CanvasRenderingContext2D | null {
  const ratio = devicePixelRatio;
  canvas.width = Math.round(width * ratio);
  canvas.height = Math.round(height * ratio);
  const context = canvas.getContext("2d");
  context?.scale(ratio, ratio);
  return context;
}

/** The share of the height for a count, 0 to 1. */
function heightOf(count: number, most: number, isLogarithmic: boolean): number {
  return isLogarithmic ? Math.log1p(count) / Math.log1p(most) : count / most;
}

/** Active cells over isovalues. The maximum has the height of the histogram. */
function curveOf(
  { activeCells, scale, isLogarithmic }: HistogramContent,
  width: number,
  height: number,
): Path2D {
  const curve = new Path2D();
  if (!activeCells) return curve;
  const { low, high, counts } = activeCells;
  const most = Math.max(1, ...counts);
  counts.forEach((count, i) => {
    const x = width * fraction(low + ((i + 0.5) * (high - low)) / counts.length, scale);
    const y = height - heightOf(count, most, isLogarithmic) * (height - marksHeight);
    if (i === 0) curve.moveTo(x, y);
    else curve.lineTo(x, y);
  });
  return curve;
}

function barsOf(
  { histogram, scale, isLogarithmic }: HistogramContent,
  width: number,
  height: number,
): Path2D {
  const bars = new Path2D();
  if (!histogram) return bars;
  const { low, high } = histogram;
  const counts = withoutGaps(histogram.counts);
  const most = Math.max(1, ...counts);
  const binWidth = (high - low) / counts.length;
  counts.forEach((count, i) => {
    if (count <= 0) return;
    const left = width * fraction(low + i * binWidth, scale);
    const right = width * fraction(low + (i + 1) * binWidth, scale);
    const tall = heightOf(count, most, isLogarithmic) * (height - marksHeight);
    bars.rect(left, height - tall, Math.max(right - left, 0.75), tall);
  });
  return bars;
}

function ticksOf({ suggestions, scale }: HistogramContent, width: number, height: number): Path2D {
  const ticks = new Path2D();
  for (const suggestion of suggestions) {
    const x = width * fraction(suggestion, scale);
    ticks.moveTo(x, height - 7);
    ticks.lineTo(x + 4, height);
    ticks.lineTo(x - 4, height);
    ticks.closePath();
  }
  return ticks;
}

/**
 * If all values are whole numbers, and their range has fewer of them than there are bins, some bins
 * are always empty. They are filled from their neighbours.
 */
export function withoutGaps(counts: readonly number[]): number[] {
  return counts.map((count, i) => {
    const before = counts[i - 1] ?? 0;
    const after = counts[i + 1] ?? 0;
    return count === 0 && before > 0 && after > 0 ? (before + after) / 2 : count;
  });
}
