/** A worker that decodes chunks with its own WebAssembly instance. */
// Not imported from the core's index, because the program of a worker must not refer to a WebAssembly
// file.
import { CoreError } from "../core/calls.ts";
import type { Core } from "../core/core.ts";
import { type CoreProgram, instantiateCore } from "../core/instantiate_core.ts";
import type { DecodedChunk } from "../core/types.ts";
import { failureOf, type WorkerFailure } from "../core/worker_failure.ts";
import type { DecodeJob } from "./decoder.ts";

/** The first message: the module to use. See WorkerPoolOptions. The worker replies with `isReady`. */
export interface WorkerStart {
  program: CoreProgram;
}

export interface WorkerRequest {
  id: number;
  job: DecodeJob;
  bytes: Uint8Array;
}

export type WorkerResponse =
  | { isReady: true }
  | { id: number; decoded: DecodedChunk }
  | ({ id: number } & WorkerFailure);

const worker = globalThis as unknown as {
  onmessage: ((event: MessageEvent<WorkerStart | WorkerRequest>) => void) | null;
  postMessage(response: WorkerResponse, transfer: Transferable[]): void;
};

let program: CoreProgram | undefined;
let core: Promise<Core> | undefined;

/** Makes an instance. The previous one, if any, has aborted and cannot be used again. */
function replaceCore(): void {
  if (program) core = instantiateCore(program);
  core?.catch(() => {}); // each request reports the error
}

worker.onmessage = async ({ data }) => {
  if ("program" in data) {
    program = data.program;
    replaceCore();
    worker.postMessage({ isReady: true }, []);
    return;
  }
  const { id, job, bytes } = data;
  try {
    if (!core) throw new CoreError("internal", "the worker received a chunk before its module");
    const decoded = (await core).decodeChunk(job, bytes);
    const buffers = [decoded.samples.buffer, decoded.clusters.buffer] as ArrayBuffer[];
    worker.postMessage({ id, decoded }, buffers);
  } catch (error) {
    if (!(error instanceof CoreError)) replaceCore();
    worker.postMessage({ id, ...failureOf(error) }, []);
  }
};
