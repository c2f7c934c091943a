import type { FieldScale, LineTick } from "./types.ts";

/** Most ticks of a legend: more could not be told apart. */
const mostTicks = 50;

/**
 * A distance of contour lines that gives about ten of them: 1, 2 or 5 times a power of ten. With a logarithmic scale,
 * it is a distance of logarithms to base 10. `range`: that which is shown (shownRange).
 */
export function fittingInterval([low, high]: readonly [number, number], scale: FieldScale): number {
  const length = scale === "logarithmic" ? Math.log10(high / low) : high - low;
  const tenth = length / 10;
  if (!(tenth > 0) || !Number.isFinite(tenth)) return 1;
  const exponent = Math.floor(Math.log10(tenth));
  const digits = tenth / 10 ** exponent;
  // The borders are the geometric means.
  const digit = digits < Math.SQRT2 ? 1 : digits < 10 ** 0.5 ? 2 : digits < 50 ** 0.5 ? 5 : 10;
  return Number(`${digit}e${exponent}`);
}

/**
 * The ticks of the contour lines in a legend; none if there are too many. `range`: as for fittingInterval. `colours`:
 * evenly spaced along the colour map, as "rgb(r g b)".
 */
export function lineTicks(
  range: readonly [number, number],
  scale: FieldScale,
  interval: number,
  colours: readonly string[],
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
    return { at, isDark: isBright(colours[Math.round(at * (colours.length - 1))] ?? "") };
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
