import type { VoxelType } from "../builder/types.ts";

/** The layout of the voxels in a file without a header. */
export interface RawLayout {
  dims: [number, number, number];
  type: VoxelType;
  bigEndian: boolean;
  skipBytes: number;
}

export const voxelBytes: Readonly<Record<VoxelType, number>> = {
  u8: 1,
  i8: 1,
  u16: 2,
  i16: 2,
  u32: 4,
  i32: 4,
  u64: 8,
  i64: 8,
  f32: 4,
  f64: 8,
};

const typeWords: readonly [RegExp, VoxelType][] = [
  [/uint8|u8|uchar|8ui/, "u8"],
  [/int8|i8|8si/, "i8"],
  [/uint16|u16|ushort|16ui/, "u16"],
  [/int16|i16|short|16si/, "i16"],
  [/uint32|u32/, "u32"],
  [/int32|i32/, "i32"],
  [/float64|f64|double/, "f64"],
  [/float32|f32|float/, "f32"],
];

/** The size of a volume in bytes. In its file, the volume begins after `skipBytes`. */
export function bytesOf({ dims: [x, y, z], type }: Pick<RawLayout, "dims" | "type">): number {
  return x * y * z * voxelBytes[type];
}

/**
 * Guesses the layout of a raw file from its name ("head_256x256x109_uint8.raw"), or else from its
 * size. If neither helps, returns the largest cube that the file can contain.
 */
export function guessRaw(name: string, bytes: number): RawLayout {
  const lower = name.toLowerCase();
  const named = /(\d{1,6})[x_×-](\d{1,6})[x_×-](\d{1,6})/.exec(lower);
  const type = typeWords.find(([word]) => word.test(lower))?.[1];
  const bigEndian = /(^|[^a-z])(be|bigendian|msb)([^a-z]|$)/.test(lower);
  const types: VoxelType[] = type ? [type] : ["u8", "u16", "f32", "f64"];
  if (named) {
    const dims = named.slice(1, 4).map(Number) as [number, number, number];
    const fits = types.find((each) => bytesOf({ dims, type: each }) === bytes);
    // If the file is larger than the volume, it begins with a header. Take the largest type with which the volume
    // fits into the file.
    const held = [...types].reverse().find((each) => bytesOf({ dims, type: each }) <= bytes);
    const best = fits ?? held ?? type ?? "u8";
    const skipBytes = Math.max(0, bytes - bytesOf({ dims, type: best }));
    return { dims, type: best, bigEndian, skipBytes };
  }
  for (const each of types) {
    const dims = likelyDims(bytes / voxelBytes[each]);
    if (dims) return { dims, type: each, bigEndian, skipBytes: 0 };
  }
  const side = Math.max(2, Math.floor(Math.cbrt(bytes / voxelBytes[type ?? "u8"])));
  return { dims: [side, side, side], type: type ?? "u8", bigEndian, skipBytes: 0 };
}

/** The likely size of a volume of this many voxels: a cube, or square slices of a usual size. */
function likelyDims(voxels: number): [number, number, number] | undefined {
  if (!Number.isInteger(voxels)) return undefined;
  const side = Math.round(Math.cbrt(voxels));
  if (side > 1 && side ** 3 === voxels) return [side, side, side];
  for (const edge of [512, 256, 1024, 128, 2048, 64]) {
    const slices = voxels / edge ** 2;
    if (Number.isInteger(slices) && slices > 1 && slices <= 4 * edge) return [edge, edge, slices];
  }
  return undefined;
}
