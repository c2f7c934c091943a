import type { Surface } from "../viewer/types.ts";
import { type IsovalueScale, snapped } from "./isovalue_scale.ts";

/** Bone, flesh, and colours that stay apart beside them. */
export const surfaceColours = [
  "#d9ccb3",
  "#c8553d",
  "#4f86c6",
  "#6a994e",
  "#9d6bb3",
  "#e0a030",
  "#3d9c93",
  "#8a8f98",
] as const;

/** How far the outer of two surfaces lets the inner one show. */
const outerOpacity = 0.4;

/** Surfaces at these isovalues; colours and opacities where they are given. */
export function surfacesAt(
  isovalues: readonly number[],
  colours: readonly string[] = [],
  opacities: readonly number[] = [],
): Surface[] {
  return isovalues.map((isovalue, i) => ({
    isovalue,
    colour: colours[i] ?? surfaceColours[i % surfaceColours.length] ?? surfaceColours[0],
    opacity: opacities[i] ?? 1,
  }));
}

/**
 * One more surface, at the end of the list: at the candidate that is farthest from what is shown.
 * What usually encloses others (the lower isovalue) becomes translucent, so that both are seen.
 */
export function withAddedSurface(
  surfaces: readonly Surface[],
  suggestions: readonly number[],
  scale: IsovalueScale,
): Surface[] {
  const { low, high } = scale;
  const away = (value: number) =>
    Math.min(...surfaces.map((surface) => Math.abs(surface.isovalue - value)));
  const candidates = [...suggestions, low + 0.25 * (high - low), low + 0.6 * (high - low)];
  const farthest = candidates.reduce((best, value) => (away(value) > away(best) ? value : best));
  const isovalue = suggestions.includes(farthest) ? farthest : snapped(farthest, scale);
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
