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

/** Surfaces at these isovalues, with the given colours and opacities. */
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
