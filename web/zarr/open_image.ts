import { open, root } from "zarrita";
import type { Triple } from "../core/types.ts";
import { StreamError } from "../stream/types.ts";
import {
  type Axis,
  gridOf,
  imageAxes,
  type Multiscale,
  placement,
  spatialAxes,
  text,
  voxelType,
  ZarrError,
} from "./image_axes.ts";
import type { ZarrImage, ZarrScale } from "./types.ts";
import { type FilesByPath, shownAddress, type ZarrSource, zarrSource } from "./zarr_files.ts";

/** Metadata with more scales than this are refused. */
const maxScales = 64;
const maxVoxels = 2 ** 20;

type Node = Awaited<ReturnType<typeof open>>;
type ZarrArray = Extract<Node, { kind: "array" }>;

/**
 * Reads an OME-Zarr image, one scale of it, or an array at an address, or in a folder among `files` of
 * this device (`addressOfFolder`). The indices of axes beside x, y
 * and z are in the address's fragment (`#c=1&t=0`); the default is 0. Rejects with a ZarrError, or a
 * StreamError.
 */
export async function openImage(href: string, files?: FilesByPath): Promise<ZarrImage> {
  const address = folderOf(new URL(href));
  const indices = new URLSearchParams(address.hash.slice(1));
  address.hash = "";
  const source = zarrSource(address, files);
  const node = await nodeAt(source, "", address);
  if (node.kind === "group") return openGroup(source, node.attrs, address, indices, files);
  const parent = new URL(address);
  const name = decodeURIComponent(parent.pathname.split("/").pop() ?? "");
  parent.pathname = parent.pathname.replace(/\/[^/]*$/, "");
  const multiscale = await multiscaleAt(parent, files);
  const chosen = multiscale ? datasetsOf(multiscale).findIndex(({ path }) => path === name) : -1;
  if (multiscale && chosen >= 0) {
    const image = await imageOf(zarrSource(parent, files), multiscale, parent, indices);
    return { ...image, chosen };
  }
  const title = nameOf(address);
  const names = node.dimensionNames ?? Array(node.shape.length).fill("");
  const axes = names.map((each): Axis => ({ name: String(each) }));
  const scale = scaleOf(node, "", axes, [], indices, title, "Zarr");
  return { address: address.href, scales: [scale], chosen: 0, metadata: metadataOf([node], {}) };
}

/** The folder of an address. The address of a metadata file means the file's folder. */
function folderOf(address: URL): URL {
  address.pathname = address.pathname
    .replace(/\/(zarr\.json|\.zattrs|\.zarray|\.zgroup|\.zmetadata)$/, "")
    .replace(/\/+$/, "");
  return address;
}

/** The array or group at a path, of either version. */
async function nodeAt(source: ZarrSource, path: string, address: URL): Promise<Node> {
  const location = root(source).resolve(path);
  const has = async (name: string) => (await source.get(location.resolve(name).path)) !== undefined;
  const shown = shownAddress(address);
  const where = path ? `${shown}/${path}` : shown;
  let node: Node;
  try {
    if (await has("zarr.json")) node = await open.v3(location);
    else if (await has(".zarray")) node = await open.v2(location, { kind: "array" });
    else if (await has(".zgroup")) node = await open.v2(location, { kind: "group" });
    else {
      throw new ZarrError(
        `${where}: expected zarr.json, .zarray or .zgroup, found none of them: check the address`,
      );
    }
  } catch (error) {
    if (error instanceof StreamError || error instanceof ZarrError) throw error;
    const reason = error instanceof Error ? error.message : String(error);
    throw new ZarrError(`${where}: its metadata are not valid: ${reason}`);
  }
  if (node.kind === "array") checkCounts(node, where);
  return node;
}

function checkCounts({ shape, chunks }: ZarrArray, where: string): void {
  const isCount = (n: unknown) => Number.isSafeInteger(n) && (n as number) >= 1;
  if (!Array.isArray(shape) || !shape.every(isCount)) {
    throw new ZarrError(`${where}: expected a shape of whole numbers from 1, found ${text(shape)}`);
  }
  if (!Array.isArray(chunks) || chunks.length !== shape.length || !chunks.every(isCount)) {
    throw new ZarrError(
      `${where}: expected chunks of ${shape.length} whole numbers from 1, found ${text(chunks)}`,
    );
  }
}

async function openGroup(
  source: ZarrSource,
  attributes: Record<string, unknown>,
  address: URL,
  indices: URLSearchParams,
  files: FilesByPath | undefined,
): Promise<ZarrImage> {
  const multiscale = multiscaleOf(attributes);
  if (multiscale) return imageOf(source, multiscale, address, indices);
  const { ome = attributes } = attributes as { ome?: Record<string, unknown> };
  if ("bioformats2raw.layout" in ome || "bioformats2raw.layout" in attributes) {
    const first = new URL(address);
    first.pathname += "/0";
    const inside = await multiscaleAt(first, files);
    if (inside) return imageOf(zarrSource(first, files), inside, first, indices);
  }
  const what = "plate" in ome ? "a plate of images" : "a group without multiscales";
  throw new ZarrError(
    `${shownAddress(address)}: expected an image or an array, found ${what}: give the address of one image or array in it`,
  );
}

/** The image at an address; undefined if there is none. */
async function multiscaleAt(
  address: URL,
  files: FilesByPath | undefined,
): Promise<Multiscale | undefined> {
  try {
    const node = await nodeAt(zarrSource(address, files), "", address);
    return node.kind === "group" ? multiscaleOf(node.attrs) : undefined;
  } catch (error) {
    if (error instanceof ZarrError) return undefined;
    throw error;
  }
}

function multiscaleOf(attributes: Record<string, unknown>): Multiscale | undefined {
  const { ome = attributes } = attributes as { ome?: Record<string, unknown> };
  const { multiscales } = (ome ?? {}) as { multiscales?: unknown };
  const [first] = Array.isArray(multiscales) ? multiscales : [];
  return typeof first === "object" && first !== null ? first : undefined;
}

function datasetsOf({ datasets }: Multiscale): { path: string; steps: unknown }[] {
  const found = (Array.isArray(datasets) ? datasets : []).map((dataset) => {
    const { path, coordinateTransformations: steps } = (dataset ?? {}) as Record<string, unknown>;
    return { path, steps };
  });
  const isValid = found.length > 0 && found.length <= maxScales;
  if (isValid && found.every((each) => typeof each.path === "string")) {
    return found as { path: string; steps: unknown }[];
  }
  throw new ZarrError(
    `expected 1 to ${maxScales} datasets with paths in multiscales, found ${text(datasets)}`,
  );
}

async function imageOf(
  source: ZarrSource,
  multiscale: Multiscale,
  address: URL,
  indices: URLSearchParams,
): Promise<ZarrImage> {
  const datasets = datasetsOf(multiscale);
  const nodes = await Promise.all(datasets.map(({ path }) => nodeAt(source, path, address)));
  const title = nameOf(address);
  const arrays: ZarrArray[] = [];
  const scales = nodes.map((node, i) => {
    const { path, steps } = datasets[i] as { path: string; steps: unknown };
    if (node.kind !== "array") throw new ZarrError(`expected an array at ${path}, found a group`);
    arrays.push(node);
    const axes = imageAxes(multiscale, node.shape.length);
    const lists = [steps, multiscale.coordinateTransformations];
    return scaleOf(node, path, axes, lists, indices, title, "OME-Zarr");
  });
  const metadata = metadataOf(arrays, multiscale);
  return { address: address.href, scales, chosen: undefined, metadata };
}

function scaleOf(
  array: ZarrArray,
  path: string,
  axes: readonly Axis[],
  transformations: readonly unknown[],
  indices: URLSearchParams,
  name: string,
  format: string,
): ZarrScale {
  const { shape, chunks } = array;
  const spatial = spatialAxes(axes);
  const of = (values: readonly number[]): Triple => [
    values[spatial[0]] ?? 0,
    values[spatial[1]] ?? 0,
    values[spatial[2]] ?? 0,
  ];
  const voxels = of(shape);
  if (voxels.some((n) => n < 2 || n > maxVoxels)) {
    throw new ZarrError(
      `expected 2 to ${maxVoxels} voxels along x, y and z, found ${voxels.join(" × ")}: ` +
        "it is no volume, or too large",
    );
  }
  const notes: string[] = [];
  const fixed = axes.map((axis, i) => {
    if (spatial.includes(i)) return 0;
    return indexOf(axis.name || `axis ${i + 1}`, shape[i] ?? 1, indices, notes);
  });
  const type = voxelType(array.dtype);
  const grid = gridOf(axes, spatial, placement(transformations, shape.length), notes);
  return {
    path,
    description: { voxels, type, ...grid, name, format, notes },
    chunk: of(chunks),
    axes: spatial,
    fixed,
    voxelBytes: (voxels[0] * voxels[1] * voxels[2] * Number(type.slice(1))) / 8,
  };
}

/** The index that is read along an axis that is not spatial. */
function indexOf(axis: string, size: number, indices: URLSearchParams, notes: string[]): number {
  const given = indices.get(axis);
  const index = given === null ? 0 : Number(given);
  if (!Number.isInteger(index) || index < 0 || index >= size) {
    throw new ZarrError(`expected an index of ${axis} from 0 to ${size - 1}, found ${given}`);
  }
  if (size > 1) notes.push(`${axis}: ${index} of 0 to ${size - 1} is read`);
  return index;
}

/** The name of an image: the folder with the ending .zarr, and the path below it. */
function nameOf({ pathname }: URL): string {
  const names = pathname.split("/").filter((name) => name !== "");
  const image = names.findLastIndex((name) => /\.zarr$/i.test(name));
  const shown = image < 0 ? names.slice(-1) : names.slice(image);
  return decodeURIComponent(shown.join("-")).replace(/(\.ome)?\.zarr/i, "") || "volume";
}

function metadataOf(arrays: readonly ZarrArray[], multiscale: Multiscale): string {
  return JSON.stringify([
    multiscale,
    arrays.map(({ shape, chunks, dtype }) => [shape, chunks, dtype]),
  ]);
}
