/** Inverts bits of 64 bytes at 40 % of each of so many pieces of a store's chunks, in place. */
export function damagedChunks(bytes: Buffer, pieces: number): Buffer {
  // Chunks make up the file but for its head and, at its end, the coarse levels and pages.
  const [from, to] = [0.1 * bytes.length, 0.7 * bytes.length];
  for (let i = 0; i < pieces; ++i) {
    const at = Math.floor(from + ((i + 0.4) / pieces) * (to - from));
    for (let k = 0; k < 64; ++k) bytes[at + k] = (bytes[at + k] ?? 0) ^ 0x55;
  }
  return bytes;
}
