/** Shared by the tests in Node: the core, and the store that write_store_fixture.cpp writes. */
import { type Core, loadCore, maxHeaderBytes, type Store } from "../../web/core/index.ts";

export async function core(): Promise<Core> {
  return loadCore();
}

export { storeBytes } from "../support/store_bytes.ts";

export const voxels = [150, 131, 70] as const;
/** In the fixture, value = quantized value + offset. */
export const offset = -100;

/** The quantized value of a voxel, by the formula of tests/shared/store_fixture.h. */
export function quantized(x: number, y: number, z: number): number {
  const [dx, dy, dz] = [2 * x - voxels[0], 2 * y - voxels[1], 2 * z - voxels[2]];
  const fall = Math.trunc((600 * (dx * dx + dy * dy + dz * dz)) / (70 * 70 * 2));
  const hash = Math.imul(x * 31 + y * 17 + z * 7, 2654435761) >>> 29;
  return Math.max(0, 600 - fall) + hash;
}

/** Active cells of level 0, by brute force. */
export function countActive(quantizedIsovalue: number): number {
  const [nx, ny, nz] = voxels;
  let count = 0;
  for (let z = 0; z + 1 < nz; ++z) {
    for (let y = 0; y + 1 < ny; ++y) {
      for (let x = 0; x + 1 < nx; ++x) {
        let [low, high] = [Infinity, -Infinity];
        for (let i = 0; i < 8; ++i) {
          const value = quantized(x + (i & 1), y + ((i >> 1) & 1), z + (i >> 2));
          low = Math.min(low, value);
          high = Math.max(high, value);
        }
        if (low <= quantizedIsovalue && quantizedIsovalue < high) ++count;
      }
    }
  }
  return count;
}

export function openWhole(core: Core, bytes: Uint8Array): Store {
  const store = core.openStore(bytes.subarray(0, maxHeaderBytes));
  for (const page of store.pages()) {
    store.addPage(page.index, bytes.subarray(page.offset, page.offset + page.bytes));
  }
  return store;
}
