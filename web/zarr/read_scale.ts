import type { DataType, Array as ZarrArray } from "zarrita";
import { ZarrError } from "./image_axes.ts";
import type { ZarrScale } from "./types.ts";

/** Limits of the bytes of a layer of chunks, and of the chunks that are being read. */
const maxLayerBytes = 512 << 20;
const maxChunkBytes = 256 << 20;
/** The largest number of requests for one volume. */
const maxChunks = 200_000;
/** The number of chunks that are fetched concurrently. */
const together = 8;

type Numbers = Uint8Array | Float32Array | BigInt64Array;

/** The part of zarrita's array that is used here. */
export type ChunkedArray = Pick<ZarrArray<DataType>, "chunks" | "getChunk">;

/**
 * The chunks of a scale: their number, and the largest size (bytes) of one chunk and of a layer along
 * z.
 */
export interface ReadingPlan {
  chunks: number;
  chunkBytes: number;
  layerBytes: number;
}

/** Throws a ZarrError if the scale cannot be read in bounded memory and time. */
export function planReading(
  { description, chunk }: ZarrScale,
  whole: readonly number[],
): ReadingPlan {
  const { voxels, type } = description;
  const bytes = Number(type.slice(1)) / 8;
  const chunks = voxels.reduce(
    (product, n, axis) => product * Math.ceil(n / (chunk[axis] ?? 1)),
    1,
  );
  const chunkBytes = whole.reduce((product, n) => product * n, bytes);
  const layerBytes = voxels[0] * voxels[1] * Math.min(voxels[2], chunk[2]) * bytes;
  const advice = "choose a coarser scale, or one with other chunks";
  if (chunkBytes > maxChunkBytes || layerBytes > maxLayerBytes) {
    throw new ZarrError(
      `expected chunks of at most ${maxChunkBytes} bytes, and layers of them of at most ` +
        `${maxLayerBytes}, found ${chunkBytes} and ${layerBytes}: ${advice}`,
    );
  }
  if (chunks > maxChunks) {
    throw new ZarrError(`expected at most ${maxChunks} chunks, found ${chunks}: ${advice}`);
  }
  return { chunks, chunkBytes, layerBytes };
}

/**
 * Reads a scale, one layer of chunks along z after the other. `take` is called with the slices of a
 * layer: little-endian voxels, x fastest. `progress` is called with the number of chunks read so far,
 * and in all.
 */
export async function readScale(
  array: ChunkedArray,
  scale: ZarrScale,
  take: (slices: Uint8Array) => void,
  progress: (fraction: number) => void,
): Promise<void> {
  const { chunks } = planReading(scale, array.chunks);
  const { voxels, type } = scale.description;
  const [chunkX, chunkY, chunkZ] = scale.chunk;
  let read = 0;
  for (let z = 0; z < voxels[2]; z += chunkZ) {
    const depth = Math.min(chunkZ, voxels[2] - z);
    const layer = numbersOf(type, voxels[0] * voxels[1] * depth);
    const columns: [number, number][] = [];
    for (let y = 0; y < voxels[1]; y += chunkY) {
      for (let x = 0; x < voxels[0]; x += chunkX) columns.push([x, y]);
    }
    const readNext = async (): Promise<void> => {
      for (let column = columns.pop(); column; column = columns.pop()) {
        const [x, y] = column;
        await copyChunk(array, scale, [x, y, z], layer);
        progress(++read / chunks);
      }
    };
    await Promise.all(Array.from({ length: together }, readNext));
    take(new Uint8Array(layer.buffer));
  }
}

/** Copies the chunk that begins at a voxel into its layer. */
async function copyChunk(
  array: ChunkedArray,
  { description, chunk, axes, fixed }: ZarrScale,
  begin: readonly [number, number, number],
  layer: Numbers,
): Promise<void> {
  const coordinates = array.chunks.map((size, axis) => Math.floor((fixed[axis] ?? 0) / size));
  axes.forEach((axis, i) => {
    coordinates[axis] = (begin[i] ?? 0) / (chunk[i] ?? 1);
  });
  const { data, stride } = (await array.getChunk(coordinates)) as unknown as {
    data: Numbers;
    stride: number[];
  };
  const expected = array.chunks.reduce((product, size) => product * size, 1);
  if (data.length !== expected || data.constructor !== layer.constructor) {
    throw new ZarrError(
      `chunk ${coordinates.join("/")}: expected ${expected} voxels, found ${data.length}: it is damaged`,
    );
  }
  // The offset of the other axes' indices in the chunk.
  const offset = array.chunks.reduce(
    (sum, size, axis) => sum + ((fixed[axis] ?? 0) % size) * (stride[axis] ?? 0),
    0,
  );
  const { voxels } = description;
  const count = ([0, 1, 2] as const).map((i) => Math.min(chunk[i], voxels[i] - begin[i]));
  const [nx = 0, ny = 0, nz = 0] = count;
  const [sx = 0, sy = 0, sz = 0] = axes.map((axis) => stride[axis]);
  for (let z = 0; z < nz; ++z) {
    for (let y = 0; y < ny; ++y) {
      const from = offset + z * sz + y * sy;
      const to = (z * voxels[1] + begin[1] + y) * voxels[0] + begin[0];
      if (sx === 1) layer.set(data.subarray(from, from + nx) as never, to);
      else for (let x = 0; x < nx; ++x) layer[to + x] = data[from + x * sx] as never;
    }
  }
}

function numbersOf(type: ZarrScale["description"]["type"], length: number): Numbers {
  const constructors = {
    u8: Uint8Array,
    i8: Int8Array,
    u16: Uint16Array,
    i16: Int16Array,
    u32: Uint32Array,
    i32: Int32Array,
    u64: BigUint64Array,
    i64: BigInt64Array,
    f32: Float32Array,
    f64: Float64Array,
  };
  return new constructors[type](length) as Numbers;
}
