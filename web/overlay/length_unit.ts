import type { StoreInfo } from "../core/types.ts";

/** The unit of the world: millimetres, or voxels if nobody knows how large they are. */
export type LengthUnit = "mm" | "voxel";

/** What the readers note if a file states no distance between voxels; 1 is then assumed. */
const assumedSpacing = /\b(1,1,1|1 mm) is assumed; --spacing sets/;

/** The unit of a volume's world. With `--spacing`, the readers note nothing. */
export function unitOf({
  metadata,
  spacing,
  isSpacingGiven,
}: Pick<StoreInfo, "metadata" | "spacing" | "isSpacingGiven">): LengthUnit {
  if (isSpacingGiven || !spacing.every((length) => length === 1)) return "mm";
  return metadata.notes?.some((note) => assumedSpacing.test(note)) ? "voxel" : "mm";
}
