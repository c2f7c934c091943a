import type { VolumeDescription } from "../builder/types.ts";

/** A copy of a volume with fewer voxels. */
export interface ReducedVolume {
  description: VolumeDescription;
  /** Little-endian, x fastest. */
  voxels: Uint8Array;
}

/** The most voxels along each axis: those of one block of a store. */
const mostVoxels = 65;

/**
 * Takes the voxels nearest to evenly spaced positions, from the first to the last along each axis, so
 * that the copy covers the same part of the world. Its values are values of the volume. Structures
 * smaller than the distance of its voxels may be missing. `readSlice` reads slice z, x fastest, and is
 * called for ascending z.
 */
export function reducedVolume(
  volume: VolumeDescription,
  readSlice: (z: number) => Uint8Array,
): ReducedVolume {
  const bytes = Number(volume.type.slice(1)) / 8;
  const [xs, ys, zs] = volume.voxels.map(positions) as [number[], number[], number[]];
  const width = volume.voxels[0];
  const voxels = new Uint8Array(xs.length * ys.length * zs.length * bytes);
  let at = 0;
  for (const z of zs) {
    const slice = readSlice(z);
    for (const y of ys) {
      for (const x of xs) {
        const from = (y * width + x) * bytes;
        for (let byte = 0; byte < bytes; ++byte) voxels[at++] = slice[from + byte] ?? 0;
      }
    }
  }
  const spacing = volume.spacing ?? [1, 1, 1];
  const counts = [xs.length, ys.length, zs.length] as const;
  const wider = (axis: 0 | 1 | 2): number =>
    (spacing[axis] * (volume.voxels[axis] - 1)) / (counts[axis] - 1);
  const description: VolumeDescription = {
    ...volume,
    voxels: counts,
    spacing: [wider(0), wider(1), wider(2)],
  };
  return { description, voxels };
}

/** Evenly spaced indices of voxels, the first and the last among them. */
function positions(voxels: number): number[] {
  const count = Math.min(voxels, mostVoxels);
  return Array.from({ length: count }, (_, i) => Math.round((i * (voxels - 1)) / (count - 1)));
}
