import type { BuildStoreOptions, BuiltStore } from "../builder/index.ts";
import type { InputFile } from "./files.ts";
import { bytesOf, type RawLayout } from "./raw_guess.ts";

/** A volume among files. */
export interface VolumeCandidate {
  /** The file to open. */
  path: string;
  format: string;
  bytes: number;
  /** The layout has to be given: the file has no header. */
  needsDims: boolean;
}

/** Volumes among the files. Only names are looked at: raw files are all that can be read so far. */
export function findVolumes(files: readonly InputFile[]): VolumeCandidate[] {
  return files
    .filter(({ path }) => /\.(raw|bin|img|vol|dat)$/i.test(path))
    .map(({ path, file }) => ({ path, format: "raw", bytes: file.size, needsDims: true }));
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

/**
 * Builds the store of a raw file in workers: the same bytes as `isosplat build` with the same layout.
 * Rejects with a CoreError, with an Error for a layout that does not fit, or with the signal's reason.
 */
export async function buildRaw(
  { path, file }: InputFile,
  layout: RawLayout,
  options: BuildStoreOptions,
): Promise<BuiltStore> {
  const problem = layoutProblem(layout, file.size);
  if (problem) throw new Error(`${path}: ${problem}`);
  const { buildStore } = await import("../builder/index.ts");
  const voxels = file.slice(layout.skipBytes, layout.skipBytes + bytesOf(layout));
  const name = nameOf(path);
  const volume = { voxels: layout.dims, type: layout.type, name, format: "raw" };
  const ordered = layout.bigEndian ? await swapped(voxels, bytesOf(layout), layout) : voxels;
  return buildStore(volume, ordered, options);
}

/** The name of a file, without folders and suffix. */
export function nameOf(path: string): string {
  const name = path.slice(path.lastIndexOf("/") + 1);
  return name.replace(/\.[^.]*$/, "") || "volume";
}

/** Voxels in the other byte order, piece by piece, so that memory holds one piece at a time. */
async function swapped(voxels: Blob, bytes: number, layout: RawLayout): Promise<Blob> {
  const width = bytes / (layout.dims[0] * layout.dims[1] * layout.dims[2]);
  if (width === 1) return voxels;
  const pieceBytes = 8 << 20;
  const pieces: Blob[] = [];
  for (let at = 0; at < bytes; at += pieceBytes) {
    const piece = new Uint8Array(await voxels.slice(at, at + pieceBytes).arrayBuffer());
    for (let voxel = 0; voxel < piece.length; voxel += width) {
      piece.subarray(voxel, voxel + width).reverse();
    }
    pieces.push(new Blob([piece]));
  }
  return new Blob(pieces);
}
