import type { BuildStoreOptions, BuiltStore } from "../builder/build_store.ts";
import type { VolumeDescription } from "../builder/types.ts";
import { CoreError } from "../core/calls.ts";
import type { ReducedVolume } from "../import/reduced_volume.ts";
import type { VolumeCandidate, VolumeChoice } from "../import/types.ts";
import { deviceTexts } from "../texts/device.ts";
import { filesKey, type InputFile } from "./files.ts";
import { bytesOf, type RawLayout } from "./raw_guess.ts";

/**
 * Asks the visitor which of several volumes to read, or whether to accept the fault `problem`; the
 * choices then have the option `allow`. Resolves to undefined if the visitor chooses none. May
 * reject with `problem`.
 */
export type Chooser = (
  choices: readonly VolumeChoice[],
  problem: Error | undefined,
) => Promise<VolumeChoice | undefined>;

/** A volume whose header was read, and whose store can be built. */
export interface ReadableVolume {
  /** Number of files from which it is read. */
  files: number;
  description: VolumeDescription;
  voxelBytes: number;
  /** Whether the visitor chose it among several volumes in the files. */
  isChosen?: boolean;
  /** Equal for equal files and layouts: see filesKey. */
  key: string;
  /**
   * Builds the store in workers. Call it once. Rejects with a CoreError or the signal's reason. If
   * the volume is large, or if its build fails for lack of memory (out_of_memory), `preview` is
   * called with the store of a reduced copy, unless `cancel` was aborted before.
   */
  build(
    options: BuildStoreOptions,
    cancel: AbortSignal,
    preview: PreviewShown,
  ): Promise<BuiltStore>;
  /** Ends the worker of a volume that is not built. */
  close(): void;
}

/** Shows the store of a reduced copy. `voxels`: the number of its voxels along each axis. */
export type PreviewShown = (store: BuiltStore, voxels: readonly [number, number, number]) => void;

/** The number of voxels from which a preview is shown. The store of a smaller volume is built quickly. */
const leastPreviewed = 4_000_000;

/**
 * Begins to load the modules that read a volume and build its store. A module that fails to load is
 * loaded again when it is needed.
 */
export function warmUp(): void {
  const imports = Promise.all([import("../import/index.ts"), import("../builder/index.ts")]);
  imports
    .then(([{ compileImport }, { compileBuilder }]) =>
      Promise.all([compileImport(), compileBuilder()]),
    )
    .catch(() => {});
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
 * Reads the header of a volume. If the files contain several volumes, `choose` selects one; if it
 * selects none, the result is undefined. `findFile` finds files that the header names but that are not
 * among `files`. Rejects with a CoreError or the signal's reason.
 */
export async function openVolume(
  files: readonly InputFile[],
  { path, choice }: Pick<VolumeCandidate, "path" | "choice">,
  layout: RawLayout | undefined,
  signal: AbortSignal,
  choose: Chooser,
  findFile?: (path: string) => Promise<InputFile | undefined>,
): Promise<ReadableVolume | undefined> {
  const { ChoiceError, openVolume: open } = await import("../import/index.ts");
  const all = [...files];
  const find = async (missing: string) => {
    const file = await findFile?.(missing);
    if (file) all.push(file);
    return file;
  };
  let picked: VolumeChoice["options"] = { ...choice?.options };
  const openPicked = () =>
    open(all, { path, ...layout, ...picked, signal, findFile: find }).catch((error) => {
      if (error instanceof ChoiceError) return error;
      throw error;
    });
  /** Adds the options of the visitor's choice. Resolves to false if the visitor cancels. */
  const pick = async (choices: readonly VolumeChoice[], problem?: Error): Promise<boolean> => {
    const next = (await choose(choices, problem))?.options;
    if (next) {
      const allow = [...(picked.allow ?? []), ...(next.allow ?? [])];
      picked = { ...picked, ...next, ...(allow.length > 0 && { allow }) };
    }
    return next !== undefined;
  };
  let volume = await openPicked();
  while (volume instanceof ChoiceError || volume.choices.length > 0) {
    const problem = volume instanceof ChoiceError ? volume : undefined;
    if (!(volume instanceof ChoiceError)) volume.close();
    if (!(await pick(volume.choices, problem))) return undefined;
    volume = await openPicked();
  }
  const chosen = { path, ...layout, ...picked };
  const [x, y, z] = volume.description.voxels;
  const isLarge = x * y * z >= leastPreviewed;

  /** Builds the store of a reduced copy while the store of the volume is built. */
  const buildReduced = async (
    { description, voxels }: ReducedVolume,
    cancel: AbortSignal,
    preview: PreviewShown,
  ): Promise<void> => {
    const { buildStore } = await import("../builder/index.ts");
    const built = await buildStore(description, voxels, { workers: 1, signal: cancel });
    if (!cancel.aborted) preview(built, description.voxels);
  };
  const build = async (options: BuildStoreOptions, cancel: AbortSignal, preview: PreviewShown) => {
    // The build of the volume reports its errors.
    const show = (reduced: ReducedVolume) =>
      void buildReduced(reduced, cancel, preview).catch(() => {});
    try {
      return await volume.build({ ...options, ...(isLarge && { reduced: show }) });
    } catch (error) {
      if (error instanceof CoreError && error.status === "out_of_memory") {
        open(all, { ...chosen, signal: cancel })
          .then((copy) => copy.readReduced(cancel).finally(() => copy.close()))
          .then(show, () => {});
      }
      throw error;
    }
  };
  const parts = new Set(volume.files);
  const used = all.filter((file) => parts.has(file.path));
  return {
    files: used.length,
    description: volume.description,
    voxelBytes: volume.voxelBytes,
    isChosen: Object.keys(picked).length > 0,
    key: await filesKey(used.length > 0 ? used : all, { path, layout, ...picked }),
    build,
    close: () => volume.close(),
  };
}

/** The reason why a layout does not fit a file of this size, as a sentence; undefined if it fits. */
export function layoutProblem(layout: RawLayout, fileBytes: number): string | undefined {
  const { dims, skipBytes } = layout;
  if (dims.some((n) => !Number.isInteger(n) || n < 2 || n > 2 ** 20)) {
    return deviceTexts.wrongDims;
  }
  if (!Number.isInteger(skipBytes) || skipBytes < 0) {
    return deviceTexts.wrongSkip;
  }
  const expected = skipBytes + bytesOf(layout);
  if (expected > fileBytes) {
    return deviceTexts.wrongSize(expected, fileBytes);
  }
  return undefined;
}

/** The name of a file, without folders and suffix. */
export function nameOf(path: string): string {
  const name = path.slice(path.lastIndexOf("/") + 1);
  return name.replace(/\.[^.]*$/, "") || "volume";
}
