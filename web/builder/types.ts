/** The type of a volume's voxels: the names of voxel_type_name in shared/core/grid/voxel_type.h. */
export type VoxelType = "u8" | "i8" | "u16" | "i16" | "u32" | "i32" | "u64" | "i64" | "f32" | "f64";

/**
 * A volume, and how its store is to be built: VolumeHeader and StoreOptions of the core. The bytes of
 * the store depend on this, without `encoders` and `memoryBytes`, and on the voxels alone.
 */
export interface VolumeDescription {
  /** Voxels along x, y and z, each from 2 to 1048576. */
  voxels: readonly [number, number, number];
  type: VoxelType;
  /** The distance between neighbours along each axis, above 0. Default: 1. */
  spacing?: readonly [number, number, number];
  /** The centre of the first voxel in the world. Default: 0. */
  origin?: readonly [number, number, number];
  /** A 3×3 matrix, row by row: its columns are the axes in the world, of unit length. */
  direction?: readonly number[];
  /** The name of the volume: the name of its file without suffixes. */
  name: string;
  /** The format of its file: "NRRD", "NIfTI", … */
  format: string;
  /** What the coordinates of the world refer to (FORMAT.md). Default: unknown. */
  frameOfReference?: string;
  /** The value of a voxel is intercept + slope · voxel. */
  slope?: number;
  intercept?: number;
  /** For display. Default: the name. */
  title?: string;
  /** The unit of the values. */
  units?: string;
  /** The assumptions made when the volume was read, as sentences. */
  notes?: readonly string[];
  /** The name of the volume's file, and a hash of its path, if it is known (FORMAT.md). */
  sourceFile?: string;
  sourcePathHash?: string;
  /** The largest error of a value. Default, 0: lossless if 16 bits allow it. */
  maxError?: number;
  /** See StoreOptions::fetch_weight. Default: 1. */
  fetchWeight?: number;
}

/** The limits of a build. The store does not depend on them. */
export interface BuildLimits {
  /** The number of blocks that are encoded concurrently. Default: 1. */
  encoders?: number;
  /** The most memory that the build may take, workers included. Default: 1 GiB. */
  memoryBytes?: number;
}

export interface BuildReport {
  /** 32 hexadecimal digits. */
  contentId: string;
  storeBytes: number;
  voxelBytes: number;
  /** The memory that the build was planned with. */
  memoryBytes: number;
}

export interface BuildProgress {
  /** Of the whole build, 0 to 1. */
  fraction: number;
  /** Of all levels, since encoding began; 0: not yet known. */
  voxelsPerSecond: number;
  /** An estimate; 0: not yet known. */
  secondsLeft: number;
}
