/** The voxels of a volume, little-endian, x fastest, then y, then z. */
export type Voxels = Blob | Uint8Array;

/**
 * Reads slices of a volume synchronously; from a Blob only in workers. Reading throws if the voxels do
 * not have exactly `slices` slices of `sliceBytes` bytes.
 */
export function sliceReader(
  voxels: Voxels,
  sliceBytes: number,
  slices: number,
): (first: number, count: number, into: Uint8Array) => void {
  const isArray = voxels instanceof Uint8Array;
  const found = isArray ? voxels.byteLength : voxels.size;
  const expected = sliceBytes * slices;
  const reader = isArray ? undefined : new FileReaderSync();
  return (first, count, into) => {
    if (found !== expected) {
      throw new Error(
        `expected ${expected} bytes of voxels, found ${found}: the file is incomplete, or its header is wrong`,
      );
    }
    const [begin, end] = [first * sliceBytes, (first + count) * sliceBytes];
    into.set(
      isArray
        ? voxels.subarray(begin, end)
        : new Uint8Array((reader as FileReaderSync).readAsArrayBuffer(voxels.slice(begin, end))),
    );
  };
}
