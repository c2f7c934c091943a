/** A worker that decodes chunks, with a WebAssembly instance of its own. */
import { type Core, CoreError, loadCore } from "../core/index.ts";
import { type DecodeJob, decodeChecked } from "./decoder.ts";

/** The first message: what the worker is to run. See WorkerPool. */
export interface WorkerStart {
  renderer: WebAssembly.Module | undefined;
}

export interface WorkerRequest {
  id: number;
  job: DecodeJob;
  bytes: Uint8Array;
}

export type WorkerAnswer =
  | { id: number; samples: Uint32Array }
  | { id: number; status: string; message: string };

const worker = globalThis as unknown as {
  onmessage: ((event: MessageEvent<WorkerStart | WorkerRequest>) => void) | null;
  postMessage(answer: WorkerAnswer, transfer: Transferable[]): void;
};

let start: WorkerStart | undefined;
let core: Promise<Core> | undefined;

/** An instance; the one before, if any, has aborted, and cannot go on. */
function begin(): void {
  core = loadCore(start?.renderer ? { renderer: start.renderer } : {});
  core.catch(() => {}); // told for each chunk
}

worker.onmessage = async ({ data }) => {
  if ("renderer" in data) {
    start = data;
    begin();
    return;
  }
  try {
    if (!core) throw new CoreError("internal", "the worker was given a chunk before its program");
    const samples = decodeChecked(await core, data.job, data.bytes);
    worker.postMessage({ id: data.id, samples }, [samples.buffer as ArrayBuffer]);
  } catch (error) {
    const status = error instanceof CoreError ? error.status : "worker_lost";
    if (!(error instanceof CoreError)) begin();
    const message = error instanceof Error ? error.message : String(error);
    worker.postMessage({ id: data.id, status, message }, []);
  }
};
