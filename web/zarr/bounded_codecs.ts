import { registry } from "zarrita";

/** What zarrita tells a codec about the chunks of an array. */
interface ChunkShape {
  shape: readonly number[];
}

/** The largest voxel, and what may stand beside the voxels of a chunk (bytes). */
const maxVoxelBytes = 8;
const extraBytes = 1024;

/** Inflates with a limit: a chunk that is larger than its array's chunks is hostile or damaged. */
class BoundedInflate {
  readonly kind = "bytes_to_bytes";
  readonly #format: "gzip" | "deflate";
  readonly #most: number;

  constructor(format: "gzip" | "deflate", { shape }: ChunkShape) {
    this.#format = format;
    this.#most = shape.reduce((product, n) => product * n, maxVoxelBytes) + extraBytes;
  }

  encode(): never {
    throw new Error("chunks are only read");
  }

  async decode(bytes: Uint8Array): Promise<Uint8Array> {
    const inflated = new Blob([bytes as BlobPart])
      .stream()
      .pipeThrough(new DecompressionStream(this.#format));
    const parts: Uint8Array[] = [];
    let size = 0;
    const reader = inflated.getReader();
    for (;;) {
      const { done, value } = await reader.read();
      if (done) break;
      size += value.length;
      if (size > this.#most) {
        void reader.cancel().catch(() => {});
        throw new Error(`expected at most ${this.#most} bytes in a chunk, found more`);
      }
      parts.push(value);
    }
    const whole = new Uint8Array(size);
    let at = 0;
    for (const part of parts) {
      whole.set(part, at);
      at += part.length;
    }
    return whole;
  }
}

/** Replaces the codecs that would inflate a chunk to any size. */
export function boundCodecs(): void {
  for (const [name, format] of [
    ["gzip", "gzip"],
    ["zlib", "deflate"],
  ] as const) {
    const codec = {
      fromConfig: (_: unknown, chunk: ChunkShape) => new BoundedInflate(format, chunk),
    };
    for (const key of [name, `numcodecs.${name}`]) {
      registry.set(key, (() => codec) as unknown as Parameters<typeof registry.set>[1]);
    }
  }
}
