import { CoreError } from "../core/calls.ts";
import type { Core } from "../core/core.ts";
import { faultOfStatus } from "../stream/faults.ts";
import { hexadecimal } from "../stream/file_source.ts";
import { StreamError } from "../stream/types.ts";

/** A store in a bundle (shared/core/scene/BUNDLE.md). Offsets are those of the bundle unless stated. */
export interface BundledFile {
  path: string;
  fileBytes: number;
  headerBytes: number;
  /** Relative to the beginning of the store. */
  bootstrapOffset: number;
  bootstrapBytes: number;
  contentId: string;
  coarseOffset: number;
  fineOffset: number;
}

/** A range of a store that lies in one piece in its bundle. */
export interface Piece {
  storeOffset: number;
  bundleOffset: number;
  bytes: number;
}

export interface BundleHeader {
  /** UTF-8. */
  scene: Uint8Array;
  stores: ReadonlyMap<string, BundledFile>;
  headerBytes: number;
  /** The size of all coarse parts, which follow the header. */
  coarseBytes: number;
  /** The checksum of the header, 16 hex digits. Two bundles with the same checksum have the same stores. */
  checksum: string;
}

const prefixBytes = 64;
const recordBytes = 56;
const checksumBytes = 8;

/**
 * Reads a bundle's header. The header is untrusted, so the core checks it. If `bytes` does not contain the whole
 * header, returns the size of the header. Throws a StreamError.
 */
export function parseBundleHeader(
  core: Core,
  bytes: Uint8Array,
  name: string,
): BundleHeader | number {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  try {
    core.checkBundle(bytes);
  } catch (error) {
    const status = error instanceof CoreError ? error.status : "internal";
    if (status === "truncated" && bytes.length >= prefixBytes) return view.getUint32(12, true);
    const message = `${name}: ${error instanceof Error ? error.message : String(error)}`;
    throw new StreamError(faultOfStatus(status) ?? "internal", message, error);
  }
  const u32 = (at: number): number => view.getUint32(at, true);
  // At most 2^48: exact.
  const u64 = (at: number): number => u32(at) + u32(at + 4) * 2 ** 32;
  const headerBytes = u32(12);
  const coarseBytes = u64(24);
  const sceneBytes = u32(32);
  const stores = new Map<string, BundledFile>();
  let at = prefixBytes + padded(sceneBytes);
  let coarseOffset = headerBytes;
  let fineOffset = headerBytes + coarseBytes;
  for (let count = u32(36); count > 0; --count) {
    const pathBytes = u32(at + 28);
    const begin = at + recordBytes;
    const path = new TextDecoder().decode(bytes.subarray(begin, begin + pathBytes));
    const store: BundledFile = {
      path,
      fileBytes: u64(at),
      bootstrapOffset: u64(at + 8),
      bootstrapBytes: u64(at + 16),
      headerBytes: u32(at + 24),
      contentId: hexadecimal(bytes.subarray(at + 32, at + 48)),
      coarseOffset,
      fineOffset,
    };
    stores.set(path, store);
    coarseOffset += coarseBytesOf(store);
    fineOffset += store.fileBytes - coarseBytesOf(store);
    at = begin + padded(pathBytes);
  }
  return {
    scene: bytes.subarray(prefixBytes, prefixBytes + sceneBytes),
    stores,
    headerBytes,
    coarseBytes,
    checksum: hexadecimal(
      bytes
        .subarray(headerBytes - checksumBytes, headerBytes)
        .slice()
        .reverse(),
    ),
  };
}

function padded(bytes: number): number {
  return Math.ceil(bytes / 8) * 8;
}

/** The size of the coarse part of a store: its header and its bootstrap range, which lie next to each other. */
export function coarseBytesOf({ headerBytes, bootstrapBytes }: BundledFile): number {
  return headerBytes + bootstrapBytes;
}

/** Maps a range of a store to ranges of the bundle, in ascending order. The range must lie within the store. */
export function piecesOf(store: BundledFile, offset: number, bytes: number): Piece[] {
  const { headerBytes, bootstrapOffset, bootstrapBytes, coarseOffset, fineOffset } = store;
  const bootstrapEnd = bootstrapOffset + bootstrapBytes;
  const all: Piece[] = [
    { storeOffset: 0, bundleOffset: coarseOffset, bytes: headerBytes },
    { storeOffset: headerBytes, bundleOffset: fineOffset, bytes: bootstrapOffset - headerBytes },
    {
      storeOffset: bootstrapOffset,
      bundleOffset: coarseOffset + headerBytes,
      bytes: bootstrapBytes,
    },
    {
      storeOffset: bootstrapEnd,
      bundleOffset: fineOffset + bootstrapOffset - headerBytes,
      bytes: store.fileBytes - bootstrapEnd,
    },
  ];
  return all.flatMap((piece) => {
    const begin = Math.max(piece.storeOffset, offset);
    const end = Math.min(piece.storeOffset + piece.bytes, offset + bytes);
    if (end <= begin) return [];
    const bundleOffset = piece.bundleOffset + begin - piece.storeOffset;
    return [{ storeOffset: begin, bundleOffset, bytes: end - begin }];
  });
}
