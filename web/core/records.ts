import {
  chunkBytes,
  pageBytes,
  readChunk,
  readPage,
  readStoreInfo,
} from "../../build/wasm/web/layouts.js";
import type { StoreInfo, StoreMetadata, Triple } from "./types.ts";

/** A chunk, as the directory of the store describes it (IsosplatChunk in shared/wasm/records.h). */
export interface Chunk {
  /** A small number that stays the same while the store is open. */
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
export function readInfo(record: Uint8Array, metadata: Uint8Array): StoreInfo {
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
  };
}

/** A store opens even if its metadata is not JSON: nothing but texts depends on it. */
function parseMetadata(bytes: Uint8Array): StoreMetadata {
  try {
    const parsed: unknown = JSON.parse(new TextDecoder().decode(bytes));
    return typeof parsed === "object" && parsed !== null ? (parsed as StoreMetadata) : {};
  } catch {
    return {};
  }
}
