/** Splits a batch into its chunks, so that other batches can be composed of them (server/HTTP.md). */

const headerBytes = 48;
const padded = (bytes: number) => Math.ceil(bytes / 16) * 16;

/**
 * The addresses of the chunks of a batch, each as in a request for the chunk alone; undefined if the
 * request is not for a batch.
 */
export function chunkAddresses(url: string): string[] | undefined {
  const { origin, pathname, searchParams } = new URL(url);
  const chunks = searchParams.get("chunks");
  if (!pathname.endsWith("/batch") || !chunks) return undefined;
  const base = `${origin}${pathname.slice(0, -"batch".length)}chunks/`;
  return chunks.split(",").map((chunk) => base + chunk);
}

/** The chunks in the response of a batch, in order; fewer, if it was truncated or has an error. */
export function chunksInFrames(answer: Uint8Array): Uint8Array[] {
  const chunks: Uint8Array[] = [];
  const view = new DataView(answer.buffer, answer.byteOffset, answer.byteLength);
  for (let at = 0; at + headerBytes <= answer.length; ) {
    const bytes = view.getUint32(at, true);
    const status = view.getUint32(at + 4, true);
    const from = at + headerBytes;
    if (status !== 0 || from + bytes > answer.length) break;
    chunks.push(answer.slice(from, from + bytes));
    at = from + padded(bytes);
  }
  return chunks;
}

/**
 * Composes the response of a batch from chunks with these addresses. Frames have sizes and positions.
 * The other fields that a server sets are 0, because the directory has them too.
 */
export function framesOf(addresses: readonly string[], chunks: readonly Uint8Array[]): Uint8Array {
  const frames = new Uint8Array(
    chunks.reduce((sum, { length }) => sum + headerBytes + padded(length), 0),
  );
  const view = new DataView(frames.buffer);
  let at = 0;
  for (const [i, chunk] of chunks.entries()) {
    const indices = /\/chunks\/(\d+)\/(\d+)\.(\d+)\.(\d+)\/(\d+)$/.exec(addresses[i] ?? "") ?? [];
    const words = [chunk.length, 0, ...indices.slice(1).map(Number)];
    for (const [k, word] of words.entries()) view.setUint32(at + 4 * k, word, true);
    frames.set(chunk, at + headerBytes);
    at += headerBytes + padded(chunk.length);
  }
  return frames;
}
