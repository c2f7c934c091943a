import { fraction, type IsovalueScale } from "./isovalue_scale.ts";

export interface HistogramMark {
  value: number;
  colour: string;
  /** The one that the slider moves. */
  isActive: boolean;
}

export interface HistogramContent {
  scale: IsovalueScale;
  /** Voxels per equal part of low … high, values. */
  histogram: { low: number; high: number; counts: readonly number[] } | undefined;
  suggestions: readonly number[];
  marks: readonly HistogramMark[];
}

const markHead = 5;

/**
 * Draws how often each value occurs, with a logarithmic scale (air outnumbers bone a thousand to
 * one), the suggested isovalues as ticks, and the isosurfaces as lines. Colours are the element's
 * CSS: color for bars, --tick for ticks.
 */
export function drawHistogram(canvas: HTMLCanvasElement, content: HistogramContent): void {
  const ratio = devicePixelRatio;
  const width = canvas.clientWidth;
  const height = canvas.clientHeight;
  if (width === 0 || height === 0) return;
  canvas.width = Math.round(width * ratio);
  canvas.height = Math.round(height * ratio);
  const context = canvas.getContext("2d");
  if (!context) return;
  context.scale(ratio, ratio);
  const style = getComputedStyle(canvas);
  const { scale, histogram, marks } = content;
  const place = (value: number) => fraction(value, scale) * width;
  const top = markHead + 2;

  if (histogram) {
    const { low, high } = histogram;
    const counts = withoutGaps(histogram.counts);
    const most = Math.max(1, ...counts);
    const binWidth = (high - low) / counts.length;
    const bars = new Path2D();
    counts.forEach((count, i) => {
      if (count <= 0) return;
      const left = place(low + i * binWidth);
      const right = place(low + (i + 1) * binWidth);
      const tall = (Math.log1p(count) / Math.log1p(most)) * (height - top);
      bars.rect(left, height - tall, Math.max(right - left, 0.75), tall);
    });
    context.fillStyle = style.color;
    context.fill(bars);

    // What the active isosurface encloses, if dense things have high values: above the isovalue.
    const active = marks.find((mark) => mark.isActive);
    if (active) {
      context.save();
      context.beginPath();
      context.rect(place(active.value), 0, width, height);
      context.clip();
      context.fillStyle = style.getPropertyValue("--inside");
      context.fill(bars);
      context.restore();
    }
  }

  context.fillStyle = style.getPropertyValue("--tick");
  for (const suggestion of content.suggestions) {
    const x = place(suggestion);
    context.beginPath();
    context.moveTo(x, height - 7);
    context.lineTo(x + 4, height);
    context.lineTo(x - 4, height);
    context.fill();
  }

  // The active line last, on top.
  for (const mark of [...marks].sort((a, b) => Number(a.isActive) - Number(b.isActive))) {
    const x = Math.max(0.75, Math.min(width - 0.75, place(mark.value)));
    context.fillStyle = mark.isActive ? style.getPropertyValue("--line") : mark.colour;
    const thick = mark.isActive ? 2 : 1.5;
    context.fillRect(x - thick / 2, 0, thick, height);
    context.fillStyle = mark.colour;
    context.strokeStyle = style.getPropertyValue("--line");
    context.beginPath();
    context.arc(Math.max(markHead, Math.min(width - markHead, x)), markHead, markHead - 1, 0, 7);
    context.fill();
    if (mark.isActive) context.stroke();
  }
}

/**
 * Whole numbers that are fewer than the bins leave single bins empty, which says nothing of the
 * volume: they are filled from their neighbours.
 */
export function withoutGaps(counts: readonly number[]): number[] {
  return counts.map((count, i) => {
    const before = counts[i - 1] ?? 0;
    const after = counts[i + 1] ?? 0;
    return count === 0 && before > 0 && after > 0 ? (before + after) / 2 : count;
  });
}

/** The value under a pointer at this offset from the canvas's left edge. */
export function valueAt(offsetPx: number, canvas: HTMLElement, scale: IsovalueScale): number {
  const place = Math.max(0, Math.min(1, offsetPx / Math.max(canvas.clientWidth, 1)));
  return scale.low + place * (scale.high - scale.low);
}
