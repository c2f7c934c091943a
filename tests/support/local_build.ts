import { readFileSync } from "node:fs";
import {
  Builder,
  type BuilderHost,
  type BuildLimits,
  type BuildReport,
  compileBuilder,
  directBuild,
  type Encoder,
  instantiateBuilder,
  type VolumeDescription,
} from "../../web/builder/index.ts";
import { sliceReader } from "../../web/builder/voxels.ts";
import type { CompiledModule } from "../../web/core/index.ts";

const wasm = new URL("../../build/wasm/web/isosplat-builder.wasm", import.meta.url);

/** The compiled builder module. */
export function builderProgram(): Promise<CompiledModule> {
  return compileBuilder(readFileSync(wasm));
}

/** An encoder with an instance of its own, on this thread. */
export async function localEncoder(program: CompiledModule): Promise<Encoder> {
  const builder = new Builder(await instantiateBuilder(program));
  return {
    setUp: async (setup) => builder.setUp(setup),
    encode: async (task) => builder.encode(task),
    statistics: async () => builder.statistics(),
  };
}

export interface LocalBuild {
  store: Uint8Array;
  report: BuildReport;
  fractions: number[];
}

/** Builds a store in memory, directed by this thread. `voxels`: all of them, or what reads slices. */
export async function buildLocally(
  program: CompiledModule,
  encoders: readonly Encoder[],
  volume: VolumeDescription,
  voxels: Uint8Array | BuilderHost["readSlices"],
  { limits = {}, signal }: { limits?: BuildLimits; signal?: AbortSignal } = {},
): Promise<LocalBuild> {
  let store = new Uint8Array(1 << 20);
  let bytes = 0;
  const fractions: number[] = [];
  const [x, y, slices] = volume.voxels;
  const sliceBytes = (x * y * Number(volume.type.slice(1))) / 8;
  const module = await instantiateBuilder(program, {
    readSlices: typeof voxels === "function" ? voxels : sliceReader(voxels, sliceBytes, slices),
    write: (offset, part) => {
      bytes = Math.max(bytes, offset + part.byteLength);
      if (bytes > store.byteLength) {
        const larger = new Uint8Array(2 * bytes);
        larger.set(store);
        store = larger;
      }
      store.set(part, offset);
    },
    progress: (fraction) => fractions.push(fraction),
  });
  const builder = new Builder(module);
  try {
    const report = await directBuild(builder, encoders, volume, limits, signal);
    return { store: store.subarray(0, bytes), report, fractions };
  } finally {
    builder.close();
  }
}
