/** Zarr arrays that readers of it are tested with. */
import type { ZarrArrayOptions } from "./zarr.ts";

/** The value of each voxel. All values differ, so that swapped axes are detected. */
export const valueAt = (x: number, y: number, z: number) => 1 + x + 31 * y + 997 * z;
export const voxels = [13, 11, 9] as const;

const zyx = { shape: [9, 11, 13], chunks: [4, 4, 5] };
export const plainZarr = {
  ...zyx,
  version: 2,
  value: ([z = 0, y = 0, x = 0]) => valueAt(x, y, z),
} satisfies ZarrArrayOptions;
/** Arrays with the same voxels in all forms that readers must know: name, options. */
export const zarrVariants: [string, ZarrArrayOptions][] = [
  ["version 2", plainZarr],
  ["version 2, gzip", { ...plainZarr, isCompressed: true }],
  ["version 2, Blosc", { ...plainZarr, isBlosc: true }],
  ["version 2, big-endian", { ...plainZarr, isBigEndian: true }],
  ["version 2, Fortran order", { ...plainZarr, isFortran: true }],
  ["version 3", { ...plainZarr, version: 3 }],
  ["version 3, gzip", { ...plainZarr, version: 3, isCompressed: true }],
  ["version 3, shards", { ...plainZarr, version: 3, isCompressed: true, shards: [2, 1, 3] }],
  [
    "version 3, axes x, z, y",
    {
      version: 3,
      shape: [13, 9, 11],
      chunks: [5, 4, 4],
      value: ([x = 0, z = 0, y = 0]) => valueAt(x, y, z),
      dimensionNames: ["x", "z", "y"],
    },
  ],
];
