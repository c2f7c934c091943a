import { surfaceColours } from "../../viewer/surfaces.ts";
import type { Surface } from "../../viewer/types.ts";
import { type IsovalueScale, roundToScale } from "./isovalue_scale.ts";

/** Opacity of the outer of two surfaces, so that the inner one is visible. */
const outerOpacity = 0.4;

/**
 * Adds a surface at the end of the list, at the candidate isovalue farthest from the existing ones,
 * since two surfaces at one isovalue would hide each other. The surface that usually encloses the
 * others (the lower isovalue) becomes translucent, so that both are visible.
 */
export function withAddedSurface(
  surfaces: readonly Surface[],
  suggestions: readonly number[],
  scale: IsovalueScale,
): Surface[] {
  const { low, high } = scale;
  const away = (value: number) =>
    Math.min(...surfaces.map((surface) => Math.abs(surface.isovalue - value)));
  const inside = suggestions.filter((value) => value > low && value < high);
  const shares = [0.25, 0.6].map((share) => roundToScale(low + share * (high - low), scale));
  const candidates = [...inside, ...shares, ...gapMidpoints(surfaces, scale)];
  const farthest = (values: readonly number[]) =>
    values.reduce((best, value) => (away(value) > away(best) ? value : best));
  // Suggestions take precedence, if they are far enough apart to be distinguished.
  const best = farthest(inside.length > 0 ? inside : candidates);
  const isovalue = away(best) >= 0.02 * (high - low) ? best : farthest(candidates);
  const used = new Set(surfaces.map((surface) => surface.colour));
  const colour = surfaceColours.find((candidate) => !used.has(candidate)) ?? surfaceColours[0];
  const isOuter = surfaces.every((surface) => surface.isovalue > isovalue);
  const dimmed = surfaces.map((surface) =>
    surface.isovalue < isovalue && surface.opacity === 1
      ? { ...surface, opacity: outerOpacity }
      : surface,
  );
  return [...dimmed, { isovalue, colour, opacity: isOuter ? outerOpacity : 1 }];
}

/** The midpoints between neighbouring isovalues, and between them and the ends of the range. */
function gapMidpoints(surfaces: readonly Surface[], { low, high }: IsovalueScale): number[] {
  const ends = [low, ...surfaces.map((surface) => surface.isovalue), high].sort((a, b) => a - b);
  return ends.slice(1).map((end, i) => {
    const middle = ((ends[i] ?? low) + end) / 2;
    return Number(middle.toPrecision(10));
  });
}
