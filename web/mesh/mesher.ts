import { CoreError } from "../core/calls.ts";
import { messageOfLoss, startWorker } from "../core/page_worker.ts";
import type { Chunk } from "../core/records.ts";
import { compileMesh } from "./compile_mesh.ts";
import type { MeshAnswer, MeshRequest } from "./mesh_worker.ts";
import { SurfaceMesher } from "./surface_mesher.ts";
import type { MeshJob, MeshResult } from "./types.ts";

/** Runs a job, chunk by chunk: one call at a time. */
export interface Mesher {
  /** See SurfaceMesher.add. */
  add(chunk: Chunk, bytes: Uint8Array): Promise<boolean>;
  finish(): Promise<MeshResult>;
  /** Ends the worker. */
  close(): void;
}

/** Begins a job in a worker, or on the calling thread if there are no workers (Node). */
export async function beginMesher(job: MeshJob): Promise<Mesher> {
  const program = await compileMesh();
  if (typeof Worker === "undefined") return inline(await SurfaceMesher.begin(program, job));
  const mesher = new WorkerMesher();
  try {
    await mesher.ask({ program, job });
  } catch (error) {
    mesher.close();
    throw error;
  }
  return mesher;
}

function inline(mesher: SurfaceMesher): Mesher {
  return {
    add: async (chunk, bytes) => {
      // Other tasks run between two chunks.
      await new Promise((resolve) => setTimeout(resolve));
      return mesher.add(chunk, bytes);
    },
    finish: async () => mesher.finish(),
    close: () => {},
  };
}

class WorkerMesher implements Mesher {
  readonly #worker = startWorker(
    "mesh_worker.js",
    () => new Worker(new URL("./mesh_worker.ts", import.meta.url), { type: "module" }),
  );

  async add(chunk: Chunk, bytes: Uint8Array): Promise<boolean> {
    const answer = await this.ask({ chunk, bytes });
    return "isAdded" in answer && answer.isAdded;
  }

  async finish(): Promise<MeshResult> {
    const answer = await this.ask({ finish: true });
    if ("result" in answer) return answer.result;
    throw new CoreError("internal", "the worker for meshes gave no result");
  }

  close(): void {
    this.#worker.terminate();
  }

  ask(request: MeshRequest): Promise<MeshAnswer> {
    return new Promise((resolve, reject) => {
      this.#worker.onmessage = ({ data }: MessageEvent<MeshAnswer>) => {
        if ("status" in data) reject(new CoreError(data.status, data.message));
        else resolve(data);
      };
      this.#worker.onerror = (event) => {
        event.preventDefault();
        reject(new CoreError("worker_lost", messageOfLoss(this.#worker, event)));
      };
      this.#worker.postMessage(request);
    });
  }
}
