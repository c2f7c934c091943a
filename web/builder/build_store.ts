import { CoreError } from "../core/calls.ts";
import type { CompiledModule } from "../core/instantiate.ts";
import { messageOfLoss, startWorker } from "../core/page_worker.ts";
import type { BuildWorkerMessage, BuildWorkerStart } from "./build_worker.ts";
import type { EncodeWorkerStart } from "./encode_worker.ts";
import type { Port } from "./encoder_port.ts";
import { compileBuilder } from "./module.ts";
import type { BuildLimits, BuildProgress, BuildReport, VolumeDescription } from "./types.ts";
import type { Voxels } from "./voxels.ts";

export interface BuildStoreOptions extends Omit<BuildLimits, "encoders"> {
  /** How many workers encode. Default: one per core, at most 8. */
  workers?: number;
  signal?: AbortSignal;
  progress?(progress: BuildProgress): void;
  /** The compiled module. Default: it is fetched. */
  program?: CompiledModule;
}

export interface BuiltStore {
  store: Blob;
  report: BuildReport;
}

/** Default number of workers that encode. The director is idle most of the time. */
export function defaultEncoderCount(): number {
  return Math.min(8, Math.max(1, navigator.hardwareConcurrency ?? 2));
}

/**
 * Builds a store in workers: one reads the voxels and writes the store, the others encode blocks. The
 * main thread only passes messages. Ends all workers when the build has ended, failed, or was cancelled.
 * Rejects with a CoreError, or with the signal's reason.
 */
export async function buildStore(
  volume: VolumeDescription,
  voxels: Voxels,
  options: BuildStoreOptions = {},
): Promise<BuiltStore> {
  options.signal?.throwIfAborted();
  const program = options.program ?? (await compileBuilder());
  options.signal?.throwIfAborted();
  const director = startWorker(
    "build_worker.js",
    () => new Worker(new URL("./build_worker.ts", import.meta.url), { type: "module" }),
  );
  return buildWith(
    director,
    (ports, limits) => ({ program, ports, volume, voxels, limits }) satisfies BuildWorkerStart,
    { ...options, program },
  );
}

/**
 * Like buildStore, but with another worker that directs. `start` makes its first message. It replies
 * with BuildWorkerMessages; other messages are for its owner.
 */
export async function buildWith(
  director: Worker,
  start: (ports: Port[], limits: BuildLimits) => object,
  options: BuildStoreOptions & { program: CompiledModule },
): Promise<BuiltStore> {
  const { signal, workers = defaultEncoderCount(), progress, memoryBytes, program } = options;
  const encoders = Array.from({ length: workers }, () =>
    startWorker(
      "encode_worker.js",
      () => new Worker(new URL("./encode_worker.ts", import.meta.url), { type: "module" }),
    ),
  );
  const all = [director, ...encoders];
  let abort = (): void => {};
  try {
    return await new Promise<BuiltStore>((resolve, reject) => {
      signal?.throwIfAborted();
      abort = () => reject(signal?.reason);
      signal?.addEventListener("abort", abort, { once: true });
      for (const worker of all) {
        worker.onerror = (event) => {
          event.preventDefault();
          reject(new CoreError("worker_lost", messageOfLoss(worker, event)));
        };
      }
      director.onmessage = ({ data }: MessageEvent<BuildWorkerMessage>) => {
        if ("progress" in data) progress?.(data.progress);
        else if ("store" in data) resolve(data);
        else if ("status" in data) reject(new CoreError(data.status, data.message));
      };
      const ports = encoders.map((worker) => {
        const { port1, port2 } = new MessageChannel();
        worker.postMessage({ port: port2, program } satisfies EncodeWorkerStart, [port2]);
        return port1;
      });
      const limits = memoryBytes === undefined ? {} : { memoryBytes };
      director.postMessage(start(ports, limits), ports);
    });
  } finally {
    signal?.removeEventListener("abort", abort);
    for (const worker of all) worker.terminate();
  }
}
