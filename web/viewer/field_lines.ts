import { roundBelow } from "../core/round_below.ts";
import type { FieldScale, LineTick } from "./types.ts";

/** Most ticks of a legend: more could not be told apart. */
const mostTicks = 50;

/** The same limits as those of line_weights in shared/render/passes/line_weights.cpp. */
const [mostPerValue, mostPerDecade, least] = [16, 10_000, 1e-15];

/**
 * Whether the renderer draws contour lines at this distance: at most 16 per quantized value, or 10,000 per decade.
 * quantum: the difference of two quantized values of the field (its mapping's scale).
 */
export function hasLines(interval: number, scale: FieldScale, quantum: number): boolean {
  if (!(interval > 0 && interval < Number.POSITIVE_INFINITY)) return false;
  const isLogarithmic = scale === "logarithmic";
  const density = isLogarithmic ? 1 / interval : Math.abs(quantum) / interval;
  return density >= least && density <= (isLogarithmic ? mostPerDecade : mostPerValue);
}

/**
 * A distance of contour lines that gives about ten of them: 1, 2 or 5 times a power of ten. With a logarithmic scale,
 * it is a distance of logarithms to base 10. `range`: that which is shown (shownRange).
 */
export function fittingInterval([low, high]: readonly [number, number], scale: FieldScale): number {
  const length = scale === "logarithmic" ? Math.log10(high / low) : high - low;
  if (!(length > 0) || !Number.isFinite(length)) return 1;
  return roundBelow(0.15 * length) || 1; // 7 to 17 lines
}

/**
 * The ticks of the contour lines in a legend; none if there are too many. `range`: as for fittingInterval. `colours`:
 * evenly spaced along the colour map, as "rgb(r g b)"; with colour steps, one for each of these `steps`.
 */
export function lineTicks(
  range: readonly [number, number],
  scale: FieldScale,
  interval: number,
  colours: readonly string[],
  steps = 0,
): LineTick[] {
  const [low = 0, high = 0] = scale === "logarithmic" ? range.map(Math.log10) : range;
  // Ends at a line have a tick in spite of rounding.
  const first = Math.ceil(low / interval - 1e-6);
  const last = Math.floor(high / interval + 1e-6);
  if (
    !(interval > 0 && interval < Number.POSITIVE_INFINITY) ||
    !(last - first < mostTicks) ||
    !(low < high)
  )
    return [];
  return Array.from({ length: Math.max(0, last - first + 1) }, (_, i) => {
    const at = Math.min(1, Math.max(0, ((first + i) * interval - low) / (high - low)));
    // As in scalar_beside_lines of shared/render/shaders/field_lines.glsl.
    const colour =
      steps > 1
        ? Math.min(steps - 1, Math.floor(at * steps + 1e-3))
        : Math.round(at * (colours.length - 1));
    return { at, isDark: isBright(colours[colour] ?? "") };
  });
}

/** Whether black contrasts with a colour at least as much as white: dark_lines in shared/render/passes/line_weights.cpp. */
function isBright(colour: string): boolean {
  const [red = 0, green = 0, blue = 0] = (colour.match(/\d+/g) ?? []).map((channel) => {
    const level = Number(channel) / 255;
    return level <= 0.04045 ? level / 12.92 : ((level + 0.055) / 1.055) ** 2.4;
  });
  return 0.2126 * red + 0.7152 * green + 0.0722 * blue >= 0.1791;
}
