/** A worker that decodes chunks with its own WebAssembly instance. */
// Not imported from the core's index, because the program of a worker must not refer to a WebAssembly
// file.
import { CoreError } from "../core/calls.ts";
import type { Core } from "../core/core.ts";
import { type CoreProgram, instantiateCore } from "../core/instantiate_core.ts";
import type { DecodedChunk } from "../core/types.ts";
import { failureOf, type WorkerFailure } from "../core/worker_failure.ts";
import type { DecodeJob, FieldJob } from "./decoder.ts";

/** The first message: the module to use. See WorkerPoolOptions. The worker replies with `isReady`. */
export interface WorkerStart {
  program: CoreProgram;
}

/** Chunks to decode. Small chunks are sent together, because a message takes longer than each of them. */
export type WorkerRequest = readonly WorkerTask[];

export interface WorkerTask {
  id: number;
  job: DecodeJob | FieldJob;
  bytes: Uint8Array;
}

/** The values of a field chunk are words: FieldJob. */
export type Decoded = DecodedChunk | Uint32Array;

/** The results of a request, in its order. */
export type WorkerResponse = { isReady: true } | readonly WorkerResult[];

export type WorkerResult = { id: number; decoded: Decoded } | ({ id: number } & WorkerFailure);

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
  const results: WorkerResult[] = [];
  const buffers: ArrayBuffer[] = [];
  for (const task of data) {
    const result = await decode(task);
    results.push(result);
    if (!("decoded" in result)) continue;
    const { decoded } = result;
    const arrays = decoded instanceof Uint32Array ? [decoded] : [decoded.samples, decoded.clusters];
    buffers.push(...arrays.map(({ buffer }) => buffer as ArrayBuffer));
  }
  worker.postMessage(results, buffers);
};

async function decode({ id, job, bytes }: WorkerTask): Promise<WorkerResult> {
  try {
    if (!core) throw new CoreError("internal", "the worker received a chunk before its module");
    const decoder = await core;
    if (!("field" in job)) return { id, decoded: decoder.decodeChunk(job, bytes) };
    const { samples, bits } = job.field;
    return { id, decoded: decoder.decodeField(job, bytes, samples, bits) };
  } catch (error) {
    if (!(error instanceof CoreError)) replaceCore();
    return { id, ...failureOf(error) };
  }
}
