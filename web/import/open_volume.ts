import { type BuildStoreOptions, type BuiltStore, buildWith } from "../builder/build_store.ts";
import { compileBuilder } from "../builder/module.ts";
import type { VolumeDescription } from "../builder/types.ts";
import { CoreError } from "../core/calls.ts";
import type { CompiledModule } from "../core/instantiate.ts";
import { messageOfLoss, startWorker } from "../core/page_worker.ts";
import type { ImportRequest, ImportResponse } from "./import_worker.ts";
import { compileImport } from "./module.ts";
import type { ReducedVolume } from "./reduced_volume.ts";
import {
  ChoiceError,
  type ImportedVolume,
  type ImportOptions,
  type InputFile,
  type Packing,
  type VolumeCandidate,
  type VolumeChoice,
} from "./types.ts";

export interface OpenOptions extends ImportOptions {
  /** The file or folder to open. Default: the first that findVolumes finds. */
  path?: string;
  /**
   * Called for each file that the volume names and that is not in `files`; returns undefined if it does
   * not exist.
   */
  findFile?(path: string): Promise<InputFile | undefined>;
  signal?: AbortSignal;
  /** The compiled modules. Default: they are fetched. */
  programs?: { import: CompiledModule; builder: CompiledModule };
}

/** The options, besides the volume, on which a store depends. */
export type StoreOptions = Pick<VolumeDescription, "title" | "units" | "maxError" | "fetchWeight">;

export type BuildOptions = BuildStoreOptions &
  StoreOptions & {
    /** Called with a copy with fewer voxels, before the other voxels are read. */
    reduced?: (volume: ReducedVolume) => void;
  };

/** A worker with the importer. The next request is sent after the reply to the previous one. */
class ImportWorker {
  readonly worker = startWorker(
    "import_worker.js",
    () => new Worker(new URL("./import_worker.ts", import.meta.url), { type: "module" }),
  );
  #lost = false;

  /** Rejects with a CoreError, or with the signal's reason. A worker that was lost is ended. */
  ask<Response extends ImportResponse>(
    request: ImportRequest,
    signal?: AbortSignal,
  ): Promise<Exclude<Response, { status: string }>> {
    return new Promise<Exclude<Response, { status: string }>>((resolve, reject) => {
      const fail = (status: string, message: string): void => {
        if (status === "worker_lost") this.end();
        reject(new CoreError(status, message));
      };
      if (this.#lost) return fail("worker_lost", "the volume is closed: open it again");
      signal?.throwIfAborted();
      const abort = (): void => {
        this.end();
        reject(signal?.reason);
      };
      signal?.addEventListener("abort", abort, { once: true });
      const settle = (done: () => void): void => {
        signal?.removeEventListener("abort", abort);
        done();
      };
      this.worker.onerror = (event) => {
        event.preventDefault();
        settle(() => fail("worker_lost", messageOfLoss(this.worker, event)));
      };
      this.worker.onmessage = ({ data }: MessageEvent<ImportResponse>) =>
        settle(() => {
          if ("choices" in data && data.choices) {
            reject(new ChoiceError(data.status, data.message, data.choices));
          } else if ("status" in data) fail(data.status, data.message);
          else resolve(data as Exclude<Response, { status: string }>);
        });
      this.worker.postMessage(request);
    });
  }

  end(): void {
    this.#lost = true;
    this.worker.terminate();
  }
}

async function start(
  files: readonly InputFile[],
  program: CompiledModule | undefined,
  signal: AbortSignal | undefined,
): Promise<ImportWorker> {
  signal?.throwIfAborted();
  const compiled = program ?? (await compileImport());
  const worker = new ImportWorker();
  try {
    await worker.ask({ program: compiled, files }, signal);
    return worker;
  } catch (error) {
    worker.end();
    throw error;
  }
}

/**
 * The volumes among the files, found by their names and first bytes, the largest first. Empty if there
 * is no readable volume.
 */
export async function findVolumes(
  files: readonly InputFile[],
  signal?: AbortSignal,
  program?: CompiledModule,
): Promise<VolumeCandidate[]> {
  const worker = await start(files, program, signal);
  try {
    const { found } = await worker.ask<{ found: VolumeCandidate[] }>({ find: true }, signal);
    return found;
  } finally {
    worker.end();
  }
}

/** An open volume. */
export class OpenedVolume {
  /** The volume in the form that web/builder takes. */
  readonly description: VolumeDescription;
  /** Sentences about assumptions, ignored parts and filled gaps. The store keeps them. */
  readonly notes: readonly string[];
  /** Paths of all files that the volume is read from. */
  readonly files: readonly string[];
  /** All volumes, if one of several was chosen without an option; else empty. */
  readonly choices: readonly VolumeChoice[];
  readonly #worker: ImportWorker;
  readonly #builder: CompiledModule | undefined;

  constructor(worker: ImportWorker, imported: ImportedVolume, builder?: CompiledModule) {
    const { files, choices = [], residentBytes: _, ...description } = imported;
    this.#worker = worker;
    this.#builder = builder;
    this.description = description;
    this.notes = imported.notes;
    this.files = files;
    this.choices = choices;
  }

  get voxelBytes(): number {
    const [x, y, z] = this.description.voxels;
    return (x * y * z * Number(this.description.type.slice(1))) / 8;
  }

  /** Slices along z, native-endian, x fastest. Not while the store is built. */
  async readSlices(first: number, count: number): Promise<Uint8Array> {
    const response = await this.#worker.ask<{ slices: Uint8Array }>({ read: first, count });
    return response.slices;
  }

  /**
   * Builds the store: the bytes of `isosplat build FILE`, which writes the store to the volume's
   * folder. If the volume is too large, rejects before reading it, with the status out_of_memory. Ends
   * the worker.
   */
  async build(options: BuildOptions = {}): Promise<BuiltStore> {
    const { title, units, maxError, fetchWeight, reduced } = options;
    const given = Object.entries({ title, units, maxError, fetchWeight });
    const store = Object.fromEntries(given.filter(([, value]) => value !== undefined));
    const volume: VolumeDescription = { ...this.description, ...store };
    const { memoryBytes } = options;
    this.#worker.worker.addEventListener("message", ({ data }: MessageEvent<ImportResponse>) => {
      if ("reduced" in data) reduced?.(data.reduced);
    });
    const program = options.program ?? this.#builder ?? (await compileBuilder());
    return buildWith(
      this.#worker.worker,
      (ports, limits) =>
        ({
          build: volume,
          reduces: reduced !== undefined,
          limits,
          program,
          ports,
        }) satisfies ImportRequest,
      { ...options, program, ...(memoryBytes === undefined ? {} : { memoryBytes }) },
    );
  }

  /** A copy with fewer voxels. Not while the store is built. */
  async readReduced(signal?: AbortSignal): Promise<ReducedVolume> {
    const request = { reduce: this.description };
    const response = await this.#worker.ask<{ reduced: ReducedVolume }>(request, signal);
    return response.reduced;
  }

  /** Ends the worker. */
  close(): void {
    this.#worker.end();
  }
}

/**
 * Opens a volume among files. Rejects with a CoreError, whose status and message are those of the
 * program `isosplat` for the same file, or worker_lost; or with the signal's reason. If there are
 * several volumes and the options choose none, the error is a ChoiceError.
 */
export async function openVolume(
  files: readonly InputFile[],
  options: OpenOptions = {},
): Promise<OpenedVolume> {
  const { path, findFile, signal, programs, ...importOptions } = options;
  const worker = await start(files, programs?.import, signal);
  try {
    const open = path ?? (await firstVolume(worker, files, signal));
    const request = { open, options: importOptions };
    await unpackIn(worker, request, files, signal);
    const opened = await openIn(worker, request, findFile, signal);
    return new OpenedVolume(worker, opened, programs?.builder);
  } catch (error) {
    worker.end();
    throw error;
  }
}

/** Decompresses a file that is compressed as a whole. The worker then opens its content. */
async function unpackIn(
  worker: ImportWorker,
  { open, options }: { open: string; options: ImportOptions },
  files: readonly InputFile[],
  signal: AbortSignal | undefined,
): Promise<void> {
  const { packing } = await worker.ask<{ packing: Packing | undefined }>({ packing: open }, signal);
  const input = files.find(({ path }) => path === open);
  if (packing === undefined || !input) return;
  const replace = (content: Blob) => worker.ask({ replace: open, content }, signal);
  /** Whether a file with this beginning should be decompressed. */
  const accepts = async (beginning: Blob) => {
    if (options.dims || options.type) return true;
    await replace(beginning);
    const { detected } = await worker.ask<{ detected: string }>({ detect: open }, signal);
    return detected !== "" && detected !== "compressed";
  };
  const { unpackFile } = await import("./unpack_file.ts");
  const content = await unpackFile(input, packing, accepts, signal);
  if (content) await replace(content);
}

/** Opens a volume. Missing files are requested until no more are found. */
async function openIn(
  worker: ImportWorker,
  request: Extract<ImportRequest, { open: string }>,
  findFile: OpenOptions["findFile"],
  signal: AbortSignal | undefined,
): Promise<ImportedVolume> {
  const requested = new Set<string>();
  for (;;) {
    try {
      const { opened } = await worker.ask<{ opened: ImportedVolume }>(request, signal);
      return opened;
    } catch (error) {
      if (!findFile || !(error instanceof CoreError) || error.status === "worker_lost") throw error;
      const { missing } = await worker.ask<{ missing: string[] }>({ missing: true }, signal);
      const found: InputFile[] = [];
      for (const path of missing.filter((each) => !requested.has(each))) {
        requested.add(path);
        const file = await findFile(path);
        if (file) found.push(file);
      }
      if (found.length === 0) throw error;
      await worker.ask({ add: found }, signal);
    }
  }
}

async function firstVolume(
  worker: ImportWorker,
  files: readonly InputFile[],
  signal: AbortSignal | undefined,
): Promise<string> {
  if (files.length === 1 && files[0]) return files[0].path;
  const { found } = await worker.ask<{ found: VolumeCandidate[] }>({ find: true }, signal);
  if (found[0]) return found[0].path;
  throw new CoreError(
    "unsupported_format",
    `expected a volume (NRRD, MetaImage, NIfTI, MGH, MRC, NumPy, HDF5, DICOM, TIFF, VTK, cube, VASP, XSF, OpenDX or raw) among ${files.length} files, found none: choose the files of a volume`,
  );
}
