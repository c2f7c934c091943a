import type { StoreInfo } from "../core/types.ts";

/** The unit of the world: millimetres, or voxels if nobody knows how large they are. */
export type LengthUnit = "mm" | "voxel";

/** What the readers note if a file states no distance between voxels. A reduced copy has wider ones. */
const allAssumed = /\b1,1,1 is assumed; --spacing sets/;
/** What they note of DICOM images, whose distance of slices may be known. */
const inPlaneAssumed = /\b1 mm is assumed; --spacing sets/;

/** The unit of a volume's world. With `--spacing`, the readers note nothing. */
export function unitOf({
  metadata,
  spacing,
  isSpacingGiven,
}: Pick<StoreInfo, "metadata" | "spacing" | "isSpacingGiven">): LengthUnit {
  if (isSpacingGiven) return "mm";
  const assumed = spacing.every((length) => length === 1)
    ? [allAssumed, inPlaneAssumed]
    : [allAssumed];
  const isAssumed = metadata.notes?.some((note) => assumed.some((words) => words.test(note)));
  return isAssumed ? "voxel" : "mm";
}
