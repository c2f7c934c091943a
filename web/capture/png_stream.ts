const signature = [0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a];
/** The filter type of every row: each byte minus that of its left neighbour. */
const sub = 1;
/** Bytes of compressed pixels per chunk of the file. */
const chunkBytes = 1 << 20;

/**
 * A PNG of 8 bits per channel that is written row by row: RGB, or RGBA with `hasAlpha`. Keeps only
 * the compressed bytes.
 */
export class PngStream {
  readonly #width: number;
  readonly #height: number;
  readonly #channels: 3 | 4;
  readonly #deflate: WritableStreamDefaultWriter<BufferSource>;
  readonly #parts: Promise<BlobPart[]>;
  #rows = 0;

  constructor(width: number, height: number, hasAlpha: boolean) {
    this.#width = width;
    this.#height = height;
    this.#channels = hasAlpha ? 4 : 3;
    const { readable, writable } = new CompressionStream("deflate");
    this.#deflate = writable.getWriter();
    this.#parts = dataChunks(readable);
    // A failure reaches the caller with the next row, or at the end.
    this.#parts.catch(() => {});
  }

  /** rgba: whole rows, from the top; alpha not premultiplied. */
  async addRows(rgba: Uint8Array | Uint8ClampedArray): Promise<void> {
    const rowBytes = 4 * this.#width;
    const rows = rgba.length / rowBytes;
    if (!Number.isInteger(rows) || this.#rows + rows > this.#height) {
      throw new RangeError(
        `expected whole rows of ${rowBytes} bytes, at most ${this.#height - this.#rows}, found ${rgba.length} bytes`,
      );
    }
    const channels = this.#channels;
    const filtered = new Uint8Array(rows * (1 + channels * this.#width));
    let to = 0;
    for (let row = 0; row < rows; ++row) {
      filtered[to++] = sub;
      const begin = row * rowBytes;
      for (let at = begin; at < begin + rowBytes; at += 4) {
        for (let channel = 0; channel < channels; ++channel) {
          const left = at > begin ? (rgba[at - 4 + channel] ?? 0) : 0;
          filtered[to++] = (rgba[at + channel] ?? 0) - left;
        }
      }
    }
    this.#rows += rows;
    await this.#deflate.ready;
    await this.#deflate.write(filtered);
  }

  async finish(): Promise<Blob> {
    if (this.#rows !== this.#height) {
      throw new RangeError(`expected ${this.#height} rows, found ${this.#rows}`);
    }
    await this.#deflate.close();
    const header = new DataView(new ArrayBuffer(13));
    header.setUint32(0, this.#width);
    header.setUint32(4, this.#height);
    header.setUint8(8, 8); // bits per channel
    header.setUint8(9, this.#channels === 4 ? 6 : 2); // RGBA or RGB
    const first = chunk("IHDR", new Uint8Array(header.buffer));
    const data = await this.#parts;
    const last = chunk("IEND", new Uint8Array());
    return new Blob([new Uint8Array(signature), first, ...data, last], { type: "image/png" });
  }
}

/** The chunks IDAT of compressed pixels. As blobs, the browser may keep them out of memory. */
async function dataChunks(compressed: ReadableStream<Uint8Array>): Promise<BlobPart[]> {
  const chunks: BlobPart[] = [];
  let pieces: Uint8Array[] = [];
  let bytes = 0;
  const flush = (): void => {
    const data = new Uint8Array(bytes);
    let at = 0;
    for (const piece of pieces) {
      data.set(piece, at);
      at += piece.length;
    }
    if (bytes > 0) chunks.push(new Blob([chunk("IDAT", data)]));
    pieces = [];
    bytes = 0;
  };
  const reader = compressed.getReader();
  for (;;) {
    const { done, value } = await reader.read();
    if (done) break;
    pieces.push(value);
    bytes += value.length;
    if (bytes >= chunkBytes) flush();
  }
  flush();
  return chunks;
}

/** Length, type, data, checksum: PNG specification, section 5.3. */
function chunk(type: string, data: Uint8Array): Uint8Array<ArrayBuffer> {
  const bytes = new Uint8Array(12 + data.length);
  const view = new DataView(bytes.buffer);
  view.setUint32(0, data.length);
  for (let i = 0; i < 4; ++i) bytes[4 + i] = type.charCodeAt(i);
  bytes.set(data, 8);
  view.setUint32(8 + data.length, crc32(bytes.subarray(4, 8 + data.length)));
  return bytes;
}

const crcTable = Uint32Array.from({ length: 256 }, (_, byte) => {
  let rest = byte;
  for (let bit = 0; bit < 8; ++bit) rest = rest & 1 ? 0xedb88320 ^ (rest >>> 1) : rest >>> 1;
  return rest;
});

/** PNG specification, annex D. */
function crc32(bytes: Uint8Array): number {
  let rest = 0xffffffff;
  for (const byte of bytes) rest = (crcTable[(rest ^ byte) & 255] ?? 0) ^ (rest >>> 8);
  return (rest ^ 0xffffffff) >>> 0;
}
