/**
 * Damages a store in place. Divides the part with its chunks into equal pieces, and inverts bits of
 * 64 bytes in each piece, from 40 % of it.
 */
export function damagedChunks(bytes: Buffer, pieces: number): Buffer {
  // The file consists of chunks, except for the header and the coarse tail at its end.
  const [from, to] = [0.1 * bytes.length, 0.7 * bytes.length];
  for (let i = 0; i < pieces; ++i) {
    const at = Math.floor(from + ((i + 0.4) / pieces) * (to - from));
    for (let k = 0; k < 64; ++k) bytes[at + k] = (bytes[at + k] ?? 0) ^ 0x55;
  }
  return bytes;
}
