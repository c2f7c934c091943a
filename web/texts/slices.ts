import { part } from "./part.ts";

/** The section of slices. */
export const slicesTexts = part("slices", {
  across: (axis: string) => `Slice across ${axis}`,
  voxelOf: (axis: string) => `Voxel along ${axis}`,
  at: (voxel: string, length: string) => `voxel ${voxel}, ${length}`,
  oblique: "Oblique slice",
  fromCentre: (length: string) => `${length} from the centre`,
  acrossView: "Slice across the view",
  acrossViewTitle: "An oblique slice through the centre of the volume, facing you",
  removeOblique: "Remove the oblique slice",
  black: "Black at",
  white: "White at",
  lowest: "Colours from",
  highest: "Colours to",
  colours: "Colours",
  grey: "Grey",
  wholeRange: "Whole range",
  about:
    "Slices show the values of the cells that are loaded: in full detail near the isovalues of the surfaces, elsewhere coarser. Where they are hatched, no values are loaded, or the values do not vary (such cells are not stored).",
});
