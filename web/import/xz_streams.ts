/** The byte range of a stream in an xz file. */
export interface XzStream {
  begin: number;
  end: number;
}

/** The size of a stream's header, and of its footer. */
const headerBytes = 12;
const largestIndex = 64 << 20;
/** The number of bytes of padding that are read at a time. */
const paddingBytes = 64 << 10;

/**
 * The streams of a file, in order (The .xz File Format 1.1, 2). They are found from the end: the footer
 * of a stream states the size of its index, and the index states the sizes of its blocks. Throws if
 * there are other bytes between streams.
 */
export async function xzStreams(file: Blob): Promise<XzStream[]> {
  const streams: XzStream[] = [];
  for (let end = file.size; end > 0; ) {
    const zeros = await zerosBefore(file, end);
    if (zeros > 0) {
      if (zeros % 4 !== 0) throw new Error("the padding of xz is damaged");
      end -= zeros;
      continue;
    }
    const begin = end - (await streamBytes(file, end));
    const magic = await bytesAt(file, Math.max(0, begin), begin + 6);
    if (begin < 0 || ![0xfd, 0x37, 0x7a, 0x58, 0x5a, 0].every((byte, i) => magic[i] === byte)) {
      throw new Error("an xz stream has no beginning");
    }
    streams.unshift({ begin, end });
    end = begin;
  }
  return streams;
}

async function bytesAt(file: Blob, begin: number, end: number): Promise<Uint8Array<ArrayBuffer>> {
  return new Uint8Array(await file.slice(begin, end).arrayBuffer());
}

/** The number of zeros before `end`, with which streams are padded; at most one piece of them. */
async function zerosBefore(file: Blob, end: number): Promise<number> {
  const last = await bytesAt(file, Math.max(0, end - paddingBytes), end);
  return last.byteLength - 1 - last.findLastIndex((byte) => byte !== 0);
}

/** The bytes of the stream that ends at `end`. */
async function streamBytes(file: Blob, end: number): Promise<number> {
  const footerAt = end - headerBytes;
  const footer = await bytesAt(file, Math.max(0, footerAt), end);
  if (footer.byteLength < headerBytes || footer[10] !== 0x59 || footer[11] !== 0x5a) {
    throw new Error("the last xz stream has no end");
  }
  const indexBytes = 4 * (new DataView(footer.buffer).getUint32(4, true) + 1);
  if (indexBytes > Math.min(footerAt, largestIndex)) throw new Error("the index of xz is damaged");
  const index = await bytesAt(file, footerAt - indexBytes, footerAt);
  let at = 1;
  const next = (): number => {
    for (let value = 0, scale = 1; ; scale *= 128) {
      const byte = index[at++];
      if (byte === undefined || scale > 2 ** 49) throw new Error("the index of xz is damaged");
      value += (byte & 127) * scale;
      if (byte < 128) return value;
    }
  };
  let blocks = 0;
  for (let left = next(); left > 0; left--) {
    blocks += 4 * Math.ceil(next() / 4);
    next(); // what the block becomes
  }
  return headerBytes + blocks + indexBytes + headerBytes;
}
