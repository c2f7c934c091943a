import type { VolumeDescription, VoxelType } from "../../web/builder/index.ts";
import { type Core, maxHeaderBytes } from "../../web/core/index.ts";

/**
 * The description of the volume from which the program has built a store. With this description and the
 * same voxels, web/builder builds the same bytes. `slope` and `intercept` are those of the volume's file.
 */
export function describeStore(
  core: Core,
  store: Uint8Array,
  slope = 1,
  intercept = 0,
): VolumeDescription {
  const opened = core.openStore(store.subarray(0, maxHeaderBytes));
  const { voxels, spacing, origin, direction, metadata } = opened.info;
  opened.close();
  const text = (value: unknown): string => (typeof value === "string" ? value : "");
  const { format, type, file, path_hash } = metadata.source ?? {};
  return {
    voxels,
    spacing,
    origin,
    direction,
    type: text(type) as VoxelType,
    name: text(metadata.name),
    format: text(format),
    title: text(metadata.title),
    units: text(metadata.units),
    notes: (metadata.notes ?? []) as string[],
    sourceFile: text(file),
    sourcePathHash: text(path_hash),
    slope,
    intercept,
  };
}
