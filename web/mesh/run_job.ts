import type { Chunk } from "../core/records.ts";
import { beginMesher } from "./mesher.ts";
import type { SurfaceReader } from "./surface_reader.ts";
import type { MeshJob, MeshResult } from "./types.ts";

export interface JobOptions {
  /** Ends the job; it then rejects with the signal's reason. */
  signal?: AbortSignal;
  /** Called for each chunk: the fraction of the bytes that are done, 0 to 1. */
  progress?(share: number): void;
}

/** Reads chunks and passes them to a job. */
export async function runJob(
  reader: SurfaceReader,
  chunks: readonly Chunk[],
  job: MeshJob,
  { signal = new AbortController().signal, progress }: JobOptions,
): Promise<MeshResult> {
  const all = chunks.reduce((sum, { bytes }) => sum + bytes, 0);
  let done = 0;
  const mesher = await beginMesher(job);
  try {
    await reader.read(chunks, signal, async (chunk, bytes) => {
      const isAdded = await mesher.add(chunk, bytes);
      if (isAdded) done += chunk.bytes;
      if (isAdded) progress?.(done / all);
      return isAdded;
    });
    signal.throwIfAborted();
    return await mesher.finish();
  } finally {
    mesher.close();
  }
}
