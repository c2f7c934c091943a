import type { StoreInfo, StoreMetadata, Triple } from "./types.ts";

/** A chunk as the store's directory describes it (IsosplatChunk in core_api.h). */
export interface Chunk {
  /** Small number that stays the same as long as the store is open. */
  handle: number;
  level: number;
  /** Index in blocks of the level. */
  block: Triple;
  /** Cells that the block has. */
  blockCells: Triple;
  /** Index within the block; it holds the quantized isovalues from bandBegin up to, but not, bandEnd. */
  band: number;
  bandBegin: number;
  bandEnd: number;
  /** In the store file. */
  offset: number;
  bytes: number;
  /** Samples that it decodes to. */
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

const chunkBytes = 56;
const pageBytes = 40;

function view(bytes: Uint8Array): DataView {
  return new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
}

function triple(data: DataView, at: number): Triple {
  return [data.getUint32(at, true), data.getUint32(at + 4, true), data.getUint32(at + 8, true)];
}

export function readChunks(bytes: Uint8Array): Chunk[] {
  const data = view(bytes);
  const chunks: Chunk[] = [];
  for (let at = 0; at < bytes.byteLength; at += chunkBytes) {
    const cells = data.getUint32(at + 52, true);
    chunks.push({
      offset: data.getFloat64(at, true),
      handle: data.getUint32(at + 8, true),
      level: data.getUint32(at + 12, true),
      block: triple(data, at + 16),
      band: data.getUint32(at + 28, true),
      bandBegin: data.getUint32(at + 32, true),
      bandEnd: data.getUint32(at + 36, true),
      bytes: data.getUint32(at + 40, true),
      cells: data.getUint32(at + 44, true),
      checksum: data.getUint32(at + 48, true),
      blockCells: [cells & 255, (cells >> 8) & 255, (cells >> 16) & 255],
    });
  }
  return chunks;
}

export function readPages(bytes: Uint8Array): Page[] {
  const data = view(bytes);
  const pages: Page[] = [];
  for (let at = 0; at < bytes.byteLength; at += pageBytes) {
    pages.push({
      index: at / pageBytes,
      offset: data.getFloat64(at, true),
      bytes: data.getUint32(at + 8, true),
      level: data.getUint32(at + 12, true),
      resident: data.getUint32(at + 28, true) !== 0,
    });
  }
  return pages;
}

export function readWords(bytes: Uint8Array): Uint32Array {
  return new Uint32Array(bytes.buffer, bytes.byteOffset, bytes.byteLength / 4);
}

/** Builds the info from isosplat_core_info's three results. */
export function readInfo(
  numberBytes: Uint8Array,
  contentId: Uint8Array,
  metadata: Uint8Array,
): StoreInfo {
  const numbers = new Float64Array(numberBytes.slice().buffer);
  const at = (i: number): number => numbers[i] ?? 0;
  const three = (i: number): Triple => [at(i), at(i + 1), at(i + 2)];
  const mapping: StoreInfo["mapping"] = {
    offset: at(18),
    scale: at(19),
    maxError: at(20),
    bits: at(21) === 8 ? 8 : 16,
    hasMissing: at(22) !== 0,
  };
  return {
    voxels: three(0),
    spacing: three(3),
    origin: three(6),
    direction: Array.from(numbers.slice(9, 18)),
    mapping,
    range: [mapping.offset + mapping.scale * at(23), mapping.offset + mapping.scale * at(24)],
    quantizedRange: [at(23), at(24)],
    levels: at(25),
    chunkCount: at(26),
    missingVoxels: at(27),
    fileBytes: at(28),
    contentId: Array.from(contentId, (byte) => byte.toString(16).padStart(2, "0")).join(""),
    metadata: parseMetadata(metadata),
  };
}

/** Metadata is for people: a store whose metadata is not JSON still opens. */
function parseMetadata(bytes: Uint8Array): StoreMetadata {
  try {
    const parsed: unknown = JSON.parse(new TextDecoder().decode(bytes));
    return typeof parsed === "object" && parsed !== null ? (parsed as StoreMetadata) : {};
  } catch {
    return {};
  }
}
