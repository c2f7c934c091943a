/**
 * Damages a store in place: splits its chunks into pieces, and inverts bits of 64 bytes at 40 % of
 * each.
 */
export function damagedChunks(bytes: Buffer, pieces: number): Buffer {
  // Chunks make up the file except for its header and, at its end, the coarse tail.
  const [from, to] = [0.1 * bytes.length, 0.7 * bytes.length];
  for (let i = 0; i < pieces; ++i) {
    const at = Math.floor(from + ((i + 0.4) / pieces) * (to - from));
    for (let k = 0; k < 64; ++k) bytes[at + k] = (bytes[at + k] ?? 0) ^ 0x55;
  }
  return bytes;
}
