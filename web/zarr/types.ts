import type { VolumeDescription } from "../builder/types.ts";
import type { Triple } from "../core/types.ts";
import type { FilesByPath } from "./zarr_files.ts";

/** One array of a Zarr hierarchy as a volume. An OME-Zarr image has one such array for each of its scales. */
export interface ZarrScale {
  /** The array's path below the opened address; "" is the address itself. */
  path: string;
  description: VolumeDescription;
  /** Voxels of a chunk along x, y and z. */
  chunk: Triple;
  /** The array's axes that are x, y and z. */
  axes: Triple;
  /** For each axis of the array the index that is read; 0 for x, y and z. */
  fixed: readonly number[];
  voxelBytes: number;
}

/** The content of an address in a Zarr hierarchy. */
export interface ZarrImage {
  /** The base address of the paths of the scales. */
  address: string;
  /** In the order of the metadata: the finest first. */
  scales: ZarrScale[];
  /**
   * The index in `scales` of the scale that the address names; undefined if it names the whole image.
   */
  chosen: number | undefined;
  /** The metadata as a text. If the text differs, the image is another version. */
  metadata: string;
  /** Files of this device, if the address is that of a folder among them. */
  files?: FilesByPath | undefined;
}

export interface ZarrVoxels {
  /** Little-endian, x fastest. */
  voxels: Blob;
  /** The assumptions made while reading, as sentences. */
  notes: string[];
}
