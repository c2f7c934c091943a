/**
 * A NIfTI-1 file of bytes with these dimensions. Sets only the header's fields that are not zero.
 */
export function nifti(voxels: number[], spacing: number[], values: Uint8Array): Uint8Array {
  const file = new Uint8Array(352 + values.length);
  const header = new DataView(file.buffer);
  header.setInt32(0, 348, true);
  for (const [i, n] of [3, ...voxels, 1, 1, 1, 1].entries()) header.setInt16(40 + 2 * i, n, true);
  header.setInt16(70, 2, true); // unsigned bytes
  header.setInt16(72, 8, true);
  for (const [i, s] of [1, ...spacing, 1, 1, 1, 1].entries())
    header.setFloat32(76 + 4 * i, s, true);
  header.setFloat32(108, 352, true); // where the values begin
  header.setFloat32(112, 1, true); // slope
  header.setInt16(254, 1, true); // the affine map below
  for (const [axis, s] of spacing.entries()) header.setFloat32(280 + 20 * axis, s, true);
  file.set([0x6e, 0x2b, 0x31, 0], 344);
  file.set(values, 352);
  return file;
}
