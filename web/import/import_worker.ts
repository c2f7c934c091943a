/** The worker that reads a volume's files, and directs the build of its store. */
import { Builder } from "../builder/builder.ts";
import { directBuild } from "../builder/direct.ts";
import { type Port, PortEncoder } from "../builder/encoder_port.ts";
import { instantiateBuilder } from "../builder/module.ts";
import { StoreParts } from "../builder/store_parts.ts";
import type { BuildLimits, VolumeDescription } from "../builder/types.ts";
import { CoreError } from "../core/calls.ts";
import type { CompiledModule } from "../core/instantiate.ts";
import { failureOf, type WorkerFailure } from "../core/worker_failure.ts";
import { FileTable } from "./files.ts";
import { volumesAmong } from "./find_volumes.ts";
import { Importer } from "./importer.ts";
import { instantiateImport } from "./module.ts";
import { type ReducedVolume, reducedVolume } from "./reduced_volume.ts";
import {
  ChoiceError,
  type ImportedVolume,
  type ImportOptions,
  type InputFile,
  type Packing,
  type VolumeCandidate,
  type VolumeChoice,
} from "./types.ts";

export type ImportRequest =
  | { program: CompiledModule; files: readonly InputFile[] }
  | { find: true }
  | { missing: true }
  | { add: readonly InputFile[] }
  | { packing: string }
  | { detect: string }
  | { replace: string; content: Blob }
  | { open: string; options: ImportOptions }
  | { read: number; count: number }
  | { reduce: VolumeDescription }
  | {
      build: VolumeDescription;
      /** Post a `reduced` volume before reading the others. */
      reduces: boolean;
      limits: BuildLimits;
      program: CompiledModule;
      ports: Port[];
    };

export type ImportResponse =
  | { ready: true }
  | { found: VolumeCandidate[] }
  | { opened: ImportedVolume }
  | { missing: string[] }
  | { packing: Packing | undefined }
  | { detected: string }
  | { slices: Uint8Array }
  | { reduced: ReducedVolume }
  | (WorkerFailure & { choices?: readonly VolumeChoice[] });

const worker = globalThis as unknown as {
  onmessage: ((event: MessageEvent<ImportRequest>) => void) | null;
  postMessage(message: object, transfer?: Transferable[]): void;
};

let files: readonly InputFile[] = [];
let table: FileTable;
let importer: Importer;
let sliceBytes = 0;

const detect = (path: string) => importer.detect(path);

/** A damaged file has no choices: the error of opening it states the cause. */
function choices(path: string): VolumeChoice[] {
  try {
    return importer.choices(path);
  } catch (error) {
    if (error instanceof CoreError) return [];
    throw error;
  }
}

function reduce(volume: VolumeDescription): ReducedVolume {
  const slice = new Uint8Array(sliceBytes);
  return reducedVolume(volume, (z) => {
    importer.readSlices(z, 1, slice);
    return slice;
  });
}

async function build(request: Extract<ImportRequest, { build: object }>): Promise<object> {
  const { build: volume, limits, program, ports } = request;
  let { reduces } = request;
  const parts = new StoreParts();
  let readError: unknown;
  const module = await instantiateBuilder(program, {
    readSlices: (first, count, into) => {
      try {
        // The first call: the build has enough memory.
        if (reduces) worker.postMessage({ reduced: reduce(volume) });
        reduces = false;
        importer.readSlices(first, count, into);
      } catch (error) {
        readError = error; // the builder only knows that reading failed
        throw error;
      }
    },
    write: (offset, bytes) => parts.write(offset, bytes),
    progress: (fraction, voxelsPerSecond, secondsLeft) =>
      worker.postMessage({ progress: { fraction, voxelsPerSecond, secondsLeft } }),
  });
  const encoders = ports.map((port) => new PortEncoder(port));
  try {
    const report = await directBuild(new Builder(module), encoders, volume, limits);
    return { store: parts.blob(), report };
  } catch (error) {
    throw readError ?? error;
  }
}

async function answer(request: ImportRequest): Promise<object> {
  if ("files" in request) {
    files = request.files;
    const reader = new FileReaderSync();
    table = new FileTable(files, (blob) => new Uint8Array(reader.readAsArrayBuffer(blob)));
    importer = new Importer(await instantiateImport(request.program, table));
    return { ready: true };
  }
  if ("find" in request) return { found: volumesAmong(files, detect, choices) };
  if ("missing" in request) return { missing: [...table.missing] };
  if ("add" in request) {
    table.add(request.add);
    return { ready: true };
  }
  if ("packing" in request) return { packing: importer.packing(request.packing) };
  if ("detect" in request) return { detected: detect(request.detect) };
  if ("replace" in request) {
    table.replace(request.replace, request.content);
    return { ready: true };
  }
  if ("open" in request) {
    const opened = importer.open(request.open, request.options);
    const [x, y] = opened.voxels;
    sliceBytes = (x * y * Number(opened.type.slice(1))) / 8;
    return { opened };
  }
  if ("read" in request) {
    const slices = new Uint8Array(sliceBytes * request.count);
    importer.readSlices(request.read, request.count, slices);
    return { slices };
  }
  if ("reduce" in request) return { reduced: reduce(request.reduce) };
  return build(request);
}

worker.onmessage = async ({ data }) => {
  try {
    const response = await answer(data);
    const transfer = "slices" in response ? [(response.slices as Uint8Array).buffer] : [];
    worker.postMessage(response, transfer as Transferable[]);
  } catch (error) {
    // WebAssembly that has aborted cannot be used again: the page ends the worker.
    const choices = error instanceof ChoiceError ? { choices: error.choices } : {};
    worker.postMessage({ ...failureOf(error), ...choices });
  }
};
