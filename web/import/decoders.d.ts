/** Decoders of npm packages that have no types of their own. */
declare module "unbzip2-stream/lib/bit_iterator.js" {
  /** Reads this number of bits, most significant first; null: skips to the next whole byte. */
  export interface Bits {
    (count: number | null): number;
    /** Bytes of which bits were read. */
    bytesRead: number;
  }
  /** `next`: returns the next bytes. It is called at once, and whenever the previous bytes are read. */
  export default function bitIterator(next: () => Uint8Array): Bits;
}

declare module "unbzip2-stream/lib/bzip2.js" {
  import type { Bits } from "unbzip2-stream/lib/bit_iterator.js";

  const bzip2: {
    /** Reads the header of a stream. Blocks have up to 100,000 times the returned number of bytes. */
    header(bits: Bits): number;
    /** Decodes a block. Returns the checksum so far; null at the end of the stream. */
    decompress(
      bits: Bits,
      put: (byte: number) => void,
      buffer: Int32Array,
      bufferSize: number,
      checksum: number,
    ): number | null;
  };
  export default bzip2;
}

declare module "xz-decompress" {
  const xz: {
    XzReadableStream: new (compressed: ReadableStream<Uint8Array>) => ReadableStream<Uint8Array>;
  };
  export default xz;
}
