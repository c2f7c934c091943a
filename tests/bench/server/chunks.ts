// Chunks of a store, and their addresses.
import { get } from "./hosts.ts";

/** A chunk's address, and its bytes. */
export interface Chunk {
  /** Below the server's URL. */
  path: string;
  body: Buffer;
}

/** The path of a volume's present content: /v1/volumes/NAME/ID. */
export async function contentPath(server: string, volume: string): Promise<string> {
  const { body } = await get(`${server}/v1/volumes/${volume}`);
  const { contentId } = JSON.parse(body.toString()) as { contentId: string };
  return `/v1/volumes/${volume}/${contentId}`;
}

/** The chunks of the frames of a response (server/HTTP.md). */
export function chunksOf(frames: Buffer, content: string): Chunk[] {
  const chunks: Chunk[] = [];
  for (let at = 0; at < frames.length; ) {
    const field = (i: number) => frames.readUInt32LE(at + 4 * i);
    const place = `${field(2)}/${field(3)}.${field(4)}.${field(5)}/${field(6)}`;
    const body = frames.subarray(at + 48, at + 48 + field(0));
    chunks.push({ path: `${content}/chunks/${place}`, body });
    at += 48 + Math.ceil(field(0) / 16) * 16;
  }
  return chunks;
}

/** The chunk whose size is nearest to this number of bytes. */
export function nearest(chunks: readonly Chunk[], bytes: number): Chunk {
  const distance = ({ body }: Chunk) => Math.abs(body.length - bytes);
  return chunks.reduce((best, chunk) => (distance(chunk) < distance(best) ? chunk : best));
}
