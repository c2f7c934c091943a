import {
  chunkBytes,
  fieldBytes,
  pageBytes,
  readChunk,
  readField,
  readPage,
  readStoreInfo,
  type Volume,
} from "../../build/wasm/web/layouts.js";
import type { FieldInfo, StoreInfo, StoreMetadata, Triple } from "./types.ts";

/** A chunk, as the directory of the store describes it (IsosplatChunk in shared/bindings/wasm/records.h). */
export interface Chunk {
  /** A small number that identifies the chunk while the store is open. */
  handle: number;
  level: number;
  /** The index of the block, in blocks of the level. */
  block: Triple;
  /** The size of the block in cells. */
  blockCells: Triple;
  /** The index of the band in the block. The band is [bandBegin, bandEnd), in quantized values. */
  band: number;
  bandBegin: number;
  bandEnd: number;
  /** The position in the store file. */
  offset: number;
  bytes: number;
  /** The number of samples. */
  cells: number;
  checksum: number;
}

/** A directory page (IsosplatPage). */
export interface Page {
  index: number;
  level: number;
  offset: number;
  bytes: number;
  resident: boolean;
}

/** A view of the bytes, for the functions of layouts.js. */
export function viewOf(bytes: Uint8Array): DataView {
  return new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
}

/** Reads an array of records. */
export function readAll<T>(
  bytes: Uint8Array,
  recordBytes: number,
  read: (data: DataView, at: number) => T,
): T[] {
  const data = viewOf(bytes);
  return Array.from({ length: bytes.length / recordBytes }, (_, i) => read(data, i * recordBytes));
}

/** The bytes of one record. */
export function recordOf<T>(
  bytes: number,
  write: (data: DataView, at: number, record: T) => void,
  record: T,
): Uint8Array {
  const result = new Uint8Array(bytes);
  write(viewOf(result), 0, record);
  return result;
}

/** The grid and value mapping of a store's volume. */
export function volumeRecord({ voxels, spacing, origin, direction, mapping }: StoreInfo): Volume {
  const { offset: valueOffset, scale: valueScale } = mapping;
  return { voxels, spacing, origin, direction, valueOffset, valueScale };
}

export function readChunks(bytes: Uint8Array): Chunk[] {
  return readAll(bytes, chunkBytes, readChunk);
}

export function readPages(bytes: Uint8Array): Page[] {
  return readAll(bytes, pageBytes, readPage).map((page, index) => ({
    index,
    level: page.level,
    offset: page.offset,
    bytes: page.bytes,
    resident: page.resident !== 0,
  }));
}

export function readWords(bytes: Uint8Array): Uint32Array {
  return new Uint32Array(bytes.buffer, bytes.byteOffset, bytes.byteLength / 4);
}

/** Builds the info from the results of isosplat_core_info. */
export function readInfo(record: Uint8Array, metadata: Uint8Array, fields: Uint8Array): StoreInfo {
  const info = readStoreInfo(viewOf(record), 0);
  const { valueOffset: offset, valueScale: scale, minQuantized, maxQuantized } = info;
  return {
    voxels: info.voxels,
    spacing: info.spacing,
    origin: info.origin,
    direction: info.direction,
    mapping: {
      offset,
      scale,
      maxError: info.maxError,
      bits: info.bits === 8 ? 8 : 16,
      hasMissing: info.hasMissing !== 0,
    },
    range: [offset + scale * minQuantized, offset + scale * maxQuantized],
    quantizedRange: [minQuantized, maxQuantized],
    levels: info.levels,
    chunkCount: info.chunkCount,
    missingVoxels: info.missingVoxels,
    fileBytes: info.fileBytes,
    contentId: info.contentId.map((byte) => byte.toString(16).padStart(2, "0")).join(""),
    metadata: parseMetadata(metadata),
    fields: readFields(fields),
  };
}

function readFields(bytes: Uint8Array): FieldInfo[] {
  return readAll(bytes, fieldBytes, readField).map((field) => {
    const { valueOffset: offset, valueScale: scale, maxError, minQuantized, maxQuantized } = field;
    return {
      name: String.fromCharCode(...field.name.filter((letter) => letter !== 0)),
      mapping: {
        offset,
        scale,
        maxError,
        bits: field.bits === 8 ? 8 : 16,
        hasMissing: field.hasMissing !== 0,
      },
      range: [offset + scale * minQuantized, offset + scale * maxQuantized],
      quantizedRange: [minQuantized, maxQuantized],
      missingVoxels: field.missingVoxels,
      offset: field.offset,
      bytes: field.bytes,
    };
  });
}

/**
 * Reads the metadata of a store, which may come from anywhere. A store opens even if they are not JSON,
 * because only texts depend on them. Known fields with a wrong type are left out.
 */
export function parseMetadata(bytes: Uint8Array): StoreMetadata {
  let parsed: unknown;
  try {
    parsed = JSON.parse(new TextDecoder().decode(bytes));
  } catch {
    return {};
  }
  if (!isObject(parsed)) return {};
  const isValid = ([name, value]: [string, unknown]) => metadataForms.get(name)?.(value) ?? true;
  return Object.fromEntries(Object.entries(parsed).filter(isValid));
}

const isNumber = (value: unknown): value is number => Number.isFinite(value);
const isText = (value: unknown): value is string => typeof value === "string";
const isObject = (value: unknown): value is Record<string, unknown> =>
  typeof value === "object" && value !== null && !Array.isArray(value);
const isListOf = (value: unknown, isItem: (item: unknown) => boolean): boolean =>
  Array.isArray(value) && value.every(isItem);

/** Limit of bins. No store has more, and more would be too many arguments for Math.max. */
const mostBins = 10_000;

function isBins(value: unknown): boolean {
  if (!isObject(value) || !isListOf(value.counts, (n) => isNumber(n) && n >= 0)) return false;
  const { low, high, counts } = value;
  const { length } = counts as number[];
  return isNumber(low) && isNumber(high) && low < high && length > 0 && length <= mostBins;
}

/** kMaxCategories in shared/core/categories/categories.h. */
const mostCategories = 512;

function isCategory(value: unknown): boolean {
  if (!Array.isArray(value) || !Number.isSafeInteger(value[0]) || !isText(value[1])) return false;
  return /^#[0-9a-f]{6}$/.test(value[1]) && (value.length < 3 || isText(value[2]));
}

const metadataForms = new Map<string, (value: unknown) => boolean>([
  ["name", isText],
  ["title", isText],
  ["units", isText],
  ["frame_of_reference", isText],
  ["source", isObject],
  ["histogram", isBins],
  ["active_cells", isBins],
  [
    "categories",
    (value) => isListOf(value, isCategory) && (value as unknown[]).length <= mostCategories,
  ],
  ["suggested_isovalues", (value) => isListOf(value, isNumber)],
  ["notes", (value) => isListOf(value, isText)],
]);
