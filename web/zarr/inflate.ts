/** Inflates gzip or zlib. Rejects if the bytes are damaged, or more than `most`. */
export async function inflate(
  bytes: Uint8Array,
  format: "gzip" | "deflate",
  most: number,
): Promise<Uint8Array> {
  const inflated = new Blob([bytes as BlobPart])
    .stream()
    .pipeThrough(new DecompressionStream(format));
  const collected = new Collected(most);
  const reader = inflated.getReader();
  for (;;) {
    const { done, value } = await reader.read();
    if (done) return collected.bytes();
    try {
      collected.add(value);
    } catch (error) {
      void reader.cancel().catch(() => {});
      throw error;
    }
  }
}

/** Bytes that arrive in parts, up to a limit. */
export class Collected {
  readonly #parts: Uint8Array[] = [];
  readonly #most: number;
  #size = 0;

  constructor(most: number) {
    this.#most = most;
  }

  add(part: Uint8Array): void {
    this.#size += part.length;
    if (this.#size > this.#most) {
      throw new Error(`expected at most ${this.#most} bytes in a chunk, found more`);
    }
    this.#parts.push(part);
  }

  bytes(): Uint8Array {
    const whole = new Uint8Array(this.#size);
    let at = 0;
    for (const part of this.#parts) {
      whole.set(part, at);
      at += part.length;
    }
    return whole;
  }
}
