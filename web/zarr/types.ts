import type { VolumeDescription } from "../builder/index.ts";
import type { Triple } from "../core/index.ts";

/** One array of a Zarr hierarchy as a volume. Of an OME-Zarr image, each scale is one. */
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

/** What is at an address of a Zarr hierarchy. */
export interface ZarrImage {
  /** The address that the paths of the scales begin at. */
  address: string;
  /** As in the metadata: the finest first. */
  scales: ZarrScale[];
  /** Of `scales`, the one that the address names; undefined: it names the whole image. */
  chosen: number | undefined;
  /** What the metadata say, as a text: another one is another version. */
  metadata: string;
}

export interface ZarrVoxels {
  /** Little-endian, x fastest. */
  voxels: Blob;
  /** What was assumed while reading, in sentences. */
  notes: string[];
}
