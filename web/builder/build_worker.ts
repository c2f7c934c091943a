/** The worker that directs a build: it reads the voxels and writes the store. */
import type { CompiledModule } from "../core/instantiate.ts";
import { failureOf, type WorkerFailure } from "../core/worker_failure.ts";
import { Builder } from "./builder.ts";
import { directBuild } from "./direct.ts";
import { type Port, PortEncoder } from "./encoder_port.ts";
import { instantiateBuilder } from "./module.ts";
import { StoreParts } from "./store_parts.ts";
import type { BuildLimits, BuildProgress, BuildReport, VolumeDescription } from "./types.ts";
import { sliceReader, type Voxels } from "./voxels.ts";

/** The only message to the worker. */
export interface BuildWorkerStart {
  program: CompiledModule;
  ports: Port[];
  volume: VolumeDescription;
  voxels: Voxels;
  limits: BuildLimits;
}

export type BuildWorkerMessage =
  | { progress: BuildProgress }
  | { store: Blob; report: BuildReport }
  | WorkerFailure;

const worker = globalThis as unknown as {
  onmessage: ((event: MessageEvent<BuildWorkerStart>) => void) | null;
  postMessage(message: BuildWorkerMessage): void;
};

async function build({ program, ports, volume, voxels, limits }: BuildWorkerStart): Promise<void> {
  const parts = new StoreParts();
  const [x, y, z] = volume.voxels;
  const sliceBytes = (x * y * Number(volume.type.slice(1))) / 8;
  const module = await instantiateBuilder(program, {
    readSlices: sliceReader(voxels, sliceBytes, z),
    write: (offset, bytes) => parts.write(offset, bytes),
    progress: (fraction, voxelsPerSecond, secondsLeft) =>
      worker.postMessage({ progress: { fraction, voxelsPerSecond, secondsLeft } }),
  });
  const encoders = ports.map((port) => new PortEncoder(port));
  const report = await directBuild(new Builder(module), encoders, volume, limits);
  worker.postMessage({ store: parts.blob(), report });
}

worker.onmessage = ({ data }) => {
  build(data).catch((error: unknown) => {
    worker.postMessage(failureOf(error));
  });
};
