/** Writes small Zarr hierarchies, of versions 2 and 3, for tests. */
import { mkdirSync, writeFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { gzipSync } from "node:zlib";
import Blosc from "numcodecs/blosc";

const blosc = { cname: "lz4", clevel: 5, shuffle: 1, blocksize: 0 };

export interface ZarrArrayOptions {
  version: 2 | 3;
  shape: readonly number[];
  chunks: readonly number[];
  /** The value of a voxel (uint16) by its indices along all axes. */
  value(index: readonly number[]): number;
  isCompressed?: boolean;
  /** Compression by Blosc instead of gzip. */
  isBlosc?: boolean;
  /** Version 2 only. */
  isBigEndian?: boolean;
  /** Version 2 only: the first axis is the fastest inside of chunks. */
  isFortran?: boolean;
  /** Version 3 only: chunks of a shard along each axis. */
  shards?: readonly number[];
  fill?: number;
  /** Whether a chunk is not written, so that its voxels have the fill value. */
  isAbsent?(chunk: readonly number[]): boolean;
  dimensionNames?: readonly string[];
}

export function writeJson(path: string, content: unknown): void {
  mkdirSync(dirname(path), { recursive: true });
  writeFileSync(path, JSON.stringify(content));
}

/** A group with attributes. */
export function writeGroup(folder: string, version: 2 | 3, attributes: object): void {
  if (version === 3) {
    writeJson(join(folder, "zarr.json"), { zarr_format: 3, node_type: "group", attributes });
  } else {
    writeJson(join(folder, ".zgroup"), { zarr_format: 2 });
    writeJson(join(folder, ".zattrs"), attributes);
  }
}

export async function writeArray(folder: string, options: ZarrArrayOptions): Promise<void> {
  writeJson(join(folder, options.version === 3 ? "zarr.json" : ".zarray"), metadataOf(options));
  const { shape, chunks, shards = chunks.map(() => 1), isAbsent = () => false } = options;
  const grid = shape.map((n, axis) => Math.ceil(n / (chunks[axis] ?? 1)));
  for (const shard of indices(grid.map((n, axis) => Math.ceil(n / (shards[axis] ?? 1))))) {
    const inside = [...indices(shards)].map((offset) =>
      shard.map((i, axis) => i * (shards[axis] ?? 1) + (offset[axis] ?? 0)),
    );
    const bytes = await Promise.all(
      inside.map((chunk) =>
        isAbsent(chunk) || chunk.some((i, axis) => i >= (grid[axis] ?? 0))
          ? undefined
          : chunkBytes(chunk, options),
      ),
    );
    if (bytes.every((each) => each === undefined)) continue;
    const names = shard.map(String);
    const path =
      options.version === 3 ? join(folder, "c", ...names) : join(folder, names.join("."));
    mkdirSync(dirname(path), { recursive: true });
    writeFileSync(path, options.shards ? shardOf(bytes) : (bytes[0] as Uint8Array));
  }
}

function metadataOf(options: ZarrArrayOptions): object {
  const { version, shape, chunks, shards, fill = 0, isCompressed } = options;
  if (version === 2) {
    return {
      zarr_format: 2,
      shape,
      chunks,
      dtype: options.isBigEndian ? ">u2" : "<u2",
      compressor: options.isBlosc
        ? { id: "blosc", ...blosc }
        : isCompressed
          ? { id: "gzip", level: 1 }
          : null,
      fill_value: fill,
      order: options.isFortran ? "F" : "C",
      filters: null,
    };
  }
  const codecs = [
    { name: "bytes", configuration: { endian: "little" } },
    ...(isCompressed ? [{ name: "gzip", configuration: { level: 1 } }] : []),
    ...(options.isBlosc ? [{ name: "blosc", configuration: blosc }] : []),
  ];
  const index = [{ name: "bytes", configuration: { endian: "little" } }];
  const sharding = { chunk_shape: chunks, codecs, index_codecs: index, index_location: "end" };
  const whole = chunks.map((n, axis) => n * (shards?.[axis] ?? 1));
  return {
    zarr_format: 3,
    node_type: "array",
    shape,
    data_type: "uint16",
    chunk_grid: { name: "regular", configuration: { chunk_shape: whole } },
    chunk_key_encoding: { name: "default", configuration: { separator: "/" } },
    fill_value: fill,
    codecs: shards ? [{ name: "sharding_indexed", configuration: sharding }] : codecs,
    attributes: {},
    ...(options.dimensionNames && { dimension_names: options.dimensionNames }),
  };
}

async function chunkBytes(
  chunk: readonly number[],
  options: ZarrArrayOptions,
): Promise<Uint8Array> {
  const { shape, chunks, value, fill = 0 } = options;
  const bytes = Buffer.alloc(2 * chunks.reduce((product, n) => product * n, 1));
  let at = 0;
  const order = options.isFortran ? [...chunks].reverse() : chunks;
  for (const place of indices(order)) {
    const inside = options.isFortran ? [...place].reverse() : place;
    const index = inside.map((i, axis) => i + (chunk[axis] ?? 0) * (chunks[axis] ?? 1));
    const number = index.every((i, axis) => i < (shape[axis] ?? 0)) ? value(index) : fill;
    if (options.isBigEndian) bytes.writeUInt16BE(number, at);
    else bytes.writeUInt16LE(number, at);
    at += 2;
  }
  if (options.isBlosc) return Blosc.fromConfig({ id: "blosc", ...blosc } as never).encode(bytes);
  return options.isCompressed ? gzipSync(bytes) : bytes;
}

function shardOf(chunks: readonly (Uint8Array | undefined)[]): Uint8Array {
  const index = Buffer.alloc(16 * chunks.length, 0xff);
  let offset = 0;
  chunks.forEach((chunk, i) => {
    if (!chunk) return;
    index.writeBigUInt64LE(BigInt(offset), 16 * i);
    index.writeBigUInt64LE(BigInt(chunk.length), 16 * i + 8);
    offset += chunk.length;
  });
  return Buffer.concat([...chunks.filter((chunk) => chunk !== undefined), index]);
}

/** All indices below a shape, the last one fastest. */
function* indices(shape: readonly number[]): Generator<number[]> {
  const [first, ...rest] = shape;
  if (first === undefined) yield [];
  else {
    for (let i = 0; i < first; ++i) for (const tail of indices(rest)) yield [i, ...tail];
  }
}
