import { StreamError } from "../stream/types.ts";
import type { ZarrImage, ZarrScale } from "../zarr/types.ts";
import { explained } from "./fetch_file.ts";
import { filesKey, type InputFile, keyOf } from "./files.ts";
import type { PreviewShown, ReadableVolume } from "./reading.ts";

/** The estimated share of fetching in the whole time. The network is slower than the builder. */
const fetchShare = 0.8;
/** The largest size in bytes of the scale that is shown first, unless all scales are larger. */
const mostPreviewed = 4 << 20;
/**
 * Limit of the memory for a scale's voxels and for its build, in bytes: see web/builder/README.md.
 */
const mostPlanned = 700 << 20;

/** Whether an address is that of a Zarr hierarchy, or of a node in one. */
export function isZarr({ pathname }: URL): boolean {
  return /\.zarr(\/|$)|\/(zarr\.json|\.z(attrs|array|group|metadata))$/i.test(pathname);
}

/**
 * Reads the metadata at an address. Rejects with an error that states the remedy, or with the
 * signal's reason.
 */
export async function openZarr(address: URL, signal: AbortSignal): Promise<ZarrImage> {
  const { openZarr: open } = await import("../zarr/index.ts");
  return open(address.href, signal).catch(rethrow);
}

/** The folder of the outermost Zarr hierarchy among files; undefined if there is none. "": all files. */
export function zarrFolder(files: readonly InputFile[]): string | undefined {
  const depth = (path: string) => path.split("/").length;
  return files
    .map(({ path }) => path)
    .filter((path) => /(^|\/)(zarr\.json|\.zgroup|\.zarray)$/.test(path))
    .sort((a, b) => depth(a) - depth(b))
    .map((path) => path.slice(0, Math.max(0, path.lastIndexOf("/"))))[0];
}

/** Reads the metadata of a folder among files of this device. Rejects like `openZarr`. */
export async function openZarrFolder(
  folder: string,
  files: readonly InputFile[],
  signal: AbortSignal,
): Promise<ZarrImage> {
  const { addressOfFolder, openZarr: open } = await import("../zarr/index.ts");
  const byPath = new Map(files.map(({ path, file }) => [path, file]));
  return open(addressOfFolder(folder), signal, byPath);
}

/** A scale of an image among files of this device. */
export async function zarrFolderVolume(
  image: ZarrImage,
  scale: ZarrScale,
  files: readonly InputFile[],
): Promise<ReadableVolume> {
  const key = await filesKey(files, { image: image.address, scale: scale.path });
  return { ...zarrScaleVolume(image, scale, key), files: files.length };
}

/**
 * Whether the browser can probably build the store of a scale. This is an estimate; the builder
 * decides.
 */
export function isBuildable({ description, voxelBytes }: ZarrScale): boolean {
  const [x, y] = description.voxels;
  const bytes = Number(description.type.slice(1)) / 8;
  return voxelBytes * (bytes > 2 ? 0.21 : 0.42) + 70 * x * y * Math.min(2, bytes) < mostPlanned;
}

/** The address of a scale. Opening it opens this scale, without a choice. */
export function addressOfScale(image: ZarrImage, { path }: ZarrScale, requested: URL): URL {
  const address = new URL(image.address);
  if (path) address.pathname += `/${path}`;
  address.hash = requested.hash;
  return address;
}

/**
 * The scale to show while a larger one is fetched: the largest of at most `mostPreviewed` bytes, or
 * else the smallest. Undefined if none is much smaller.
 */
function previewOf({ scales }: ZarrImage, { voxelBytes }: ZarrScale): ZarrScale | undefined {
  const smaller = scales
    .filter((scale) => scale.voxelBytes <= voxelBytes / 4)
    .sort((a, b) => a.voxelBytes - b.voxelBytes);
  return smaller.findLast((scale) => scale.voxelBytes <= mostPreviewed) ?? smaller[0];
}

/** A scale of an image as a volume. Its preview is a smaller scale, which is fetched first. */
export async function zarrVolume(
  image: ZarrImage,
  scale: ZarrScale,
  address: URL,
): Promise<ReadableVolume> {
  return zarrScaleVolume(image, scale, await keyOf([address.href, image.metadata]));
}

function zarrScaleVolume(image: ZarrImage, scale: ZarrScale, key: string): ReadableVolume {
  const { description, voxelBytes } = scale;
  const small = previewOf(image, scale);
  return {
    files: 1,
    description,
    voxelBytes,
    key,
    build: async ({ progress, ...options }, cancel, preview) => {
      const { signal = new AbortController().signal } = options;
      const { readZarr } = await import("../zarr/index.ts");
      const { buildStore } = await import("../builder/index.ts");
      if (small) await showFirst(image, small, cancel, preview);
      signal.throwIfAborted();
      const begin = performance.now();
      const { voxels, notes } = await readZarr(image, scale, {
        signal,
        progress: (read) => {
          const fraction = fetchShare * read;
          const seconds = (performance.now() - begin) / 1000;
          const secondsLeft = (seconds * (1 - fraction)) / fraction;
          progress?.({ fraction, voxelsPerSecond: 0, secondsLeft });
        },
      }).catch(rethrow);
      const volume = { ...description, notes: [...(description.notes ?? []), ...notes] };
      return buildStore(volume, voxels, {
        ...options,
        progress: ({ fraction, ...rest }) =>
          progress?.({ ...rest, fraction: fetchShare + (1 - fetchShare) * fraction }),
      });
    },
    close: () => {},
  };
}

/**
 * Fetches a small scale. Its store is built and shown after the function has returned. Faults are
 * not reported here, because fetching the chosen scale meets them too.
 */
async function showFirst(
  image: ZarrImage,
  scale: ZarrScale,
  cancel: AbortSignal,
  preview: PreviewShown,
): Promise<void> {
  const { readZarr } = await import("../zarr/index.ts");
  const { buildStore } = await import("../builder/index.ts");
  const { description } = scale;
  const read = await readZarr(image, scale, { signal: cancel }).catch(() => undefined);
  if (!read) return;
  buildStore(description, read.voxels, { workers: 1, signal: cancel }).then(
    (built) => {
      if (!cancel.aborted) preview(built, description.voxels);
    },
    () => {},
  );
}

function rethrow(error: unknown): never {
  throw error instanceof StreamError ? explained(error) : error;
}
