/** A worker for one job: it answers each message, and is terminated afterwards. */
import type { CompiledModule } from "../core/instantiate.ts";
import type { Chunk } from "../core/records.ts";
import { failureOf, type WorkerFailure } from "../core/worker_failure.ts";
import { SurfaceMesher } from "./surface_mesher.ts";
import type { MeshJob, MeshResult } from "./types.ts";

export type MeshRequest =
  | { program: CompiledModule; job: MeshJob }
  | { chunk: Chunk; bytes: Uint8Array }
  | { finish: true };

/** `isAdded`: whether the chunk was added; false: it is damaged. */
export type MeshAnswer =
  | { isBegun: true }
  | { isAdded: boolean }
  | { result: MeshResult }
  | WorkerFailure;

const worker = globalThis as unknown as {
  onmessage: ((event: MessageEvent<MeshRequest>) => void) | null;
  postMessage(answer: MeshAnswer): void;
};

let mesher: SurfaceMesher | undefined;

async function answer(request: MeshRequest): Promise<MeshAnswer> {
  if ("job" in request) {
    mesher = await SurfaceMesher.begin(request.program, request.job);
    return { isBegun: true };
  }
  if (!mesher) throw new Error("the worker received a chunk before its job");
  if ("chunk" in request) return { isAdded: mesher.add(request.chunk, request.bytes) };
  return { result: mesher.finish() };
}

worker.onmessage = async ({ data }) => {
  worker.postMessage(await answer(data).catch(failureOf));
};
