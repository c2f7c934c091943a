/** A worker that decodes chunks, with a WebAssembly instance of its own. */
import { type Core, CoreError, loadCore } from "../core/index.ts";
import { type DecodeJob, decodeChecked } from "./decoder.ts";

export interface WorkerRequest {
  id: number;
  job: DecodeJob;
  bytes: Uint8Array;
}

export type WorkerAnswer =
  | { id: number; samples: Uint32Array }
  | { id: number; status: string; message: string };

const worker = globalThis as unknown as {
  onmessage: ((event: MessageEvent<WorkerRequest>) => void) | null;
  postMessage(answer: WorkerAnswer, transfer: Transferable[]): void;
};

// Begins at once: the module is there when the first chunk comes.
const core: Promise<Core> = loadCore();

worker.onmessage = async ({ data }) => {
  try {
    const samples = decodeChecked(await core, data.job, data.bytes);
    worker.postMessage({ id: data.id, samples }, [samples.buffer as ArrayBuffer]);
  } catch (error) {
    const status = error instanceof CoreError ? error.status : "internal";
    const message = error instanceof Error ? error.message : String(error);
    worker.postMessage({ id: data.id, status, message }, []);
  }
};
