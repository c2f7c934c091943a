/** Enlarges a real volume: interpolates the values that a scanner with a finer grid would have measured. */
import type { RawVolume } from "../harness/flying_edges.ts";

/** A position on an axis of the old grid: the voxel, and the fraction of the distance to the next one. */
function place(index: number, count: number, newCount: number): [number, number] {
  const at = (index * (count - 1)) / (newCount - 1);
  const voxel = Math.min(Math.floor(at), count - 2);
  return [voxel, at - voxel];
}

/**
 * Each axis gets `factor` times as many voxels, by trilinear interpolation. Interpolated voxels are
 * smoother than measured ones. Evenly distributed noise of one grey value compensates for this,
 * also with factor 1.
 */
export function enlarge({ voxels, type, data }: RawVolume, factor: number): RawVolume {
  if (type !== "u8") throw new Error(`expected a volume of bytes, found ${type}`);
  const [nx, ny, nz] = voxels;
  const size = voxels.map((n) => Math.round(n * factor)) as RawVolume["voxels"];
  const [mx, my, mz] = size;
  const out = Buffer.alloc(mx * my * mz);
  const columns = Array.from({ length: mx }, (_, x) => place(x, nx, mx));
  const row = new Float64Array(nx);
  let random = 1;
  let to = 0;
  for (let z = 0; z < mz; ++z) {
    const [k, w] = place(z, nz, mz);
    for (let y = 0; y < my; ++y) {
      const [j, v] = place(y, ny, my);
      const at = (k * ny + j) * nx;
      for (let x = 0; x < nx; ++x) {
        const [a = 0, b = 0] = [data[at + x], data[at + nx + x]];
        const [c = 0, d = 0] = [data[at + ny * nx + x], data[at + (ny + 1) * nx + x]];
        row[x] = (1 - w) * (a + v * (b - a)) + w * (c + v * (d - c));
      }
      for (const [i, u] of columns) {
        // A linear congruential generator: the same noise on every machine.
        random = (Math.imul(random, 1664525) + 1013904223) >>> 0;
        const [left = 0, right = 0] = [row[i], row[i + 1]];
        const value = left + u * (right - left) + random / 2 ** 32 - 0.5;
        out[to++] = Math.min(255, Math.max(0, Math.round(value)));
      }
    }
  }
  return { voxels: size, type, data: out };
}

/** An NRRD file with an attached header. */
export function nrrdOf({ voxels, data }: RawVolume): Buffer {
  const header = `NRRD0004\ntype: uint8\ndimension: 3\nsizes: ${voxels.join(" ")}\nspacings: 1 1 1\nencoding: raw\n\n`;
  return Buffer.concat([Buffer.from(header), data]);
}
