import type { BuildStoreOptions, BuiltStore, VolumeDescription } from "../builder/index.ts";
import type { VolumeCandidate } from "../import/index.ts";
import { filesKey, type InputFile } from "./files.ts";
import { bytesOf, type RawLayout } from "./raw_guess.ts";
import { leastReduced, reducedVolume } from "./reduced_volume.ts";

export type { VolumeCandidate } from "../import/index.ts";

/** A volume whose header was read, and whose store can be built. */
export interface ReadableVolume {
  /** How many files it is read from. */
  files: number;
  description: VolumeDescription;
  voxelBytes: number;
  /** The same for the same files and layout: see filesKey. */
  key: string;
  /** Builds the store in workers; once. Rejects with a CoreError or the signal's reason. */
  build(options: BuildStoreOptions): Promise<BuiltStore>;
  /**
   * Builds the store of a reduced copy, also while the store of the volume is built. Undefined for a
   * volume that is small itself. Rejects as `build` does.
   */
  buildReduced(signal: AbortSignal): Promise<ReducedStore | undefined>;
  /** Ends the worker of a volume that is not built. */
  close(): void;
}

/** The store of a reduced copy of a volume. */
export interface ReducedStore extends BuiltStore {
  voxels: VolumeDescription["voxels"];
}

/** The volumes among files, the largest first. */
export async function findVolumes(
  files: readonly InputFile[],
  signal: AbortSignal,
): Promise<VolumeCandidate[]> {
  const { findVolumes: find } = await import("../import/index.ts");
  return find(files, signal);
}

/**
 * Reads the header of a volume. `findFile` is asked for files that it names and that are not among
 * `files`. Rejects with a CoreError or the signal's reason.
 */
export async function openVolume(
  files: readonly InputFile[],
  path: string,
  layout: RawLayout | undefined,
  signal: AbortSignal,
  findFile?: (path: string) => Promise<InputFile | undefined>,
): Promise<ReadableVolume> {
  const { openVolume: open } = await import("../import/index.ts");
  const all = [...files];
  const find = async (missing: string) => {
    const file = await findFile?.(missing);
    if (file) all.push(file);
    return file;
  };
  const volume = await open(files, { path, signal, findFile: find, ...layout });
  const buildReduced = async (cancel: AbortSignal): Promise<ReducedStore | undefined> => {
    const [x, y, z] = volume.description.voxels;
    if (x * y * z < leastReduced) return undefined;
    // A worker of its own: the other one directs the build.
    const copy = await open(all, { path, signal: cancel, ...layout });
    try {
      const { description, voxels } = await reducedVolume(volume.description, (slice) => {
        cancel.throwIfAborted();
        return copy.readSlices(slice, 1);
      });
      const { buildStore } = await import("../builder/index.ts");
      const built = await buildStore(description, voxels, { workers: 1, signal: cancel });
      return { ...built, voxels: description.voxels };
    } finally {
      copy.close();
    }
  };
  const parts = new Set(volume.files);
  const used = all.filter((file) => parts.has(file.path));
  return {
    files: used.length,
    description: volume.description,
    voxelBytes: volume.voxelBytes,
    key: await filesKey(used.length > 0 ? used : all, { path, layout }),
    build: (options) => volume.build(options),
    buildReduced,
    close: () => volume.close(),
  };
}

/** What is wrong with a layout for a file of this size, in a sentence; undefined: nothing. */
export function layoutProblem(layout: RawLayout, fileBytes: number): string | undefined {
  const { dims, skipBytes } = layout;
  if (dims.some((n) => !Number.isInteger(n) || n < 2 || n > 2 ** 20)) {
    return "expected whole numbers of voxels from 2 to 1048576 along each axis";
  }
  if (!Number.isInteger(skipBytes) || skipBytes < 0) {
    return "expected a whole number of bytes to skip, from 0";
  }
  const expected = skipBytes + bytesOf(layout);
  if (expected > fileBytes) {
    return `expected ${expected} bytes, found a file of ${fileBytes}: correct the size or the type`;
  }
  return undefined;
}

/** The name of a file, without folders and suffix. */
export function nameOf(path: string): string {
  const name = path.slice(path.lastIndexOf("/") + 1);
  return name.replace(/\.[^.]*$/, "") || "volume";
}
