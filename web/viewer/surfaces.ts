import type { StoreInfo } from "../core/types.ts";
import type { Surface } from "./types.ts";

/** Bone, flesh, and further colours that are easy to distinguish from them. */
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

/** The colour of the surface with this number. Colours of consecutive numbers are easy to distinguish. */
export function surfaceColour(number: number): string {
  return surfaceColours[number % surfaceColours.length] ?? surfaceColours[0];
}

export const firstLook = { colour: surfaceColours[0], opacity: 1 };

/** The volume's first suggestion, or the middle of its range. */
export function firstSurface({ metadata, range: [low, high] }: StoreInfo): Surface {
  return { isovalue: metadata.suggested_isovalues?.[0] ?? (low + high) / 2, ...firstLook };
}

/** Surfaces at these isovalues, with the given colours and opacities. `first`: the number of the first colour. */
export function surfacesAt(
  isovalues: readonly number[],
  colours: readonly string[] = [],
  opacities: readonly number[] = [],
  first = 0,
): Surface[] {
  return isovalues.map((isovalue, i) => ({
    isovalue,
    colour: colours[i] ?? surfaceColour(first + i),
    opacity: opacities[i] ?? 1,
  }));
}

/** Surfaces at these isovalues with the colours of others. Additional ones get the colour of the first. */
export function withIsovalues(
  surfaces: readonly Surface[],
  isovalues: readonly number[],
): Surface[] {
  const first = surfaces[0] ?? { isovalue: 0, ...firstLook };
  return isovalues.map((isovalue, i) => ({ ...(surfaces[i] ?? first), isovalue }));
}
