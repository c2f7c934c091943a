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
import type { ImportOptions, InputFile } from "../../web/import/index.ts";
import { importProgram, localImporter } from "./local_import.ts";

const wasm = new URL("../../build/wasm/web/isosplat-builder.wasm", import.meta.url);

/** The compiled builder module. */
export function builderProgram(): Promise<CompiledModule> {
  return compileBuilder(readFileSync(wasm));
}

/** An encoder with a separate instance of the module, on this thread. */
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

/** Builds a store in memory, on this thread. `voxels`: all voxels, or a reader of slices. */
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

/** The compiled modules that read and build, and the encoders of a build. */
export interface LocalPrograms {
  importer: CompiledModule;
  builder: CompiledModule;
  encoders: readonly Encoder[];
}

export async function localPrograms(): Promise<LocalPrograms> {
  const builder = await builderProgram();
  return { importer: await importProgram(), builder, encoders: [await localEncoder(builder)] };
}

/** The store of a volume among files, as the browser builds it. Throws the error of the reader unchanged. */
export async function buildFrom(
  { importer, builder, encoders }: LocalPrograms,
  files: readonly InputFile[],
  path: string,
  options: ImportOptions = {},
  limits: BuildLimits = {},
): Promise<Uint8Array> {
  const reader = await localImporter(importer, files);
  let readError: unknown;
  const read = (first: number, count: number, into: Uint8Array): void => {
    try {
      reader.readSlices(first, count, into);
    } catch (error) {
      readError = error;
      throw error;
    }
  };
  try {
    const volume = reader.open(path, options);
    return (await buildLocally(builder, encoders, volume, read, { limits })).store;
  } catch (error) {
    throw readError ?? error;
  }
}
