import { Decompress } from "fzstd";
import { registry } from "zarrita";
import { decodeBlosc } from "./blosc.ts";
import { Collected, inflate } from "./inflate.ts";
import { decodeLz4 } from "./lz_blocks.ts";

/** zarrita's description of the chunks of an array, for a codec. */
interface ChunkShape {
  shape: readonly number[];
}

/** Decodes bytes of a chunk; more than `most` bytes are an error. */
type Decode = (bytes: Uint8Array, most: number) => Uint8Array | Promise<Uint8Array>;

/** The largest size of a voxel, and of other data beside the voxels of a chunk (bytes). */
const maxVoxelBytes = 8;
const extraBytes = 1024;

const decoders: Readonly<Record<string, Decode>> = {
  gzip: (bytes, most) => inflate(bytes, "gzip", most),
  zlib: (bytes, most) => inflate(bytes, "deflate", most),
  zstd: inflateZstd,
  lz4: inflateLz4,
  blosc: decodeBlosc,
};

function inflateZstd(bytes: Uint8Array, most: number): Uint8Array {
  const collected = new Collected(most);
  new Decompress((part) => collected.add(part.slice())).push(bytes, true);
  return collected.bytes();
}

/** numcodecs writes the size before the block. */
function inflateLz4(bytes: Uint8Array, most: number): Uint8Array {
  if (bytes.length < 4) throw new Error("a chunk of LZ4 is cut short");
  const size = new DataView(bytes.buffer, bytes.byteOffset).getUint32(0, true);
  if (size > most) throw new Error(`expected at most ${most} bytes in a chunk, found ${size}`);
  return decodeLz4(bytes.subarray(4), size);
}

/**
 * Replaces zarrita's codecs for compressed bytes by codecs with a limit. They do not evaluate strings
 * as code, which the page's Content-Security-Policy forbids.
 */
export function replaceCodecs(): void {
  for (const [name, decode] of Object.entries(decoders)) {
    const codec = {
      fromConfig: (_: unknown, { shape }: ChunkShape) => ({
        kind: "bytes_to_bytes",
        encode: () => {
          throw new Error("chunks are only read");
        },
        decode: (bytes: Uint8Array) =>
          decode(bytes, shape.reduce((product, n) => product * n, maxVoxelBytes) + extraBytes),
      }),
    };
    for (const key of [name, `numcodecs.${name}`]) {
      registry.set(key, (() => codec) as unknown as Parameters<typeof registry.set>[1]);
    }
  }
}
