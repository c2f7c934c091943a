/** A worker that decodes chunks with its own WebAssembly instance. */
import {
  type Core,
  CoreError,
  type DecodedChunk,
  failureOf,
  loadCore,
  type WorkerFailure,
} from "../core/index.ts";
import type { DecodeJob } from "./decoder.ts";

/** The first message: the module to use. See WorkerPoolOptions. */
export interface WorkerStart {
  renderer: WebAssembly.Module | undefined;
}

export interface WorkerRequest {
  id: number;
  job: DecodeJob;
  bytes: Uint8Array;
}

export type WorkerResponse =
  | { id: number; decoded: DecodedChunk }
  | ({ id: number } & WorkerFailure);

const worker = globalThis as unknown as {
  onmessage: ((event: MessageEvent<WorkerStart | WorkerRequest>) => void) | null;
  postMessage(response: WorkerResponse, transfer: Transferable[]): void;
};

let start: WorkerStart | undefined;
let core: Promise<Core> | undefined;

/** Makes an instance. The previous one, if any, has aborted and cannot be used again. */
function instantiateCore(): void {
  core = loadCore(start?.renderer ? { renderer: start.renderer } : {});
  core.catch(() => {}); // each request reports the error
}

worker.onmessage = async ({ data }) => {
  if ("renderer" in data) {
    start = data;
    instantiateCore();
    return;
  }
  const { id, job, bytes } = data;
  try {
    if (!core) throw new CoreError("internal", "the worker received a chunk before its module");
    const decoded = (await core).decodeChunk(job, bytes);
    const buffers = [decoded.samples.buffer, decoded.clusters.buffer] as ArrayBuffer[];
    worker.postMessage({ id, decoded }, buffers);
  } catch (error) {
    if (!(error instanceof CoreError)) instantiateCore();
    worker.postMessage({ id, ...failureOf(error) }, []);
  }
};
