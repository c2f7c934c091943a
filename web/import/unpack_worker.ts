/** A worker that unpacks one file. */
import { BlobParts } from "../core/blob_parts.ts";
import type { Packing } from "./types.ts";
import { unpackStream } from "./unpack_streams.ts";

/** The bytes of the first part. */
const beginningBytes = 64 << 10;

export interface UnpackRequest {
  file: Blob;
  packing: Packing;
  /** Decompressing more than this number of bytes is an error. */
  maxBytes: number;
}

export type UnpackResponse =
  /** The first part, before the others are decompressed. */
  { beginning: Blob } | { content: Blob } | { status: string; message: string };

const worker = globalThis as unknown as {
  onmessage: ((event: MessageEvent<UnpackRequest>) => void) | null;
  postMessage(message: UnpackResponse): void;
};

class TooLarge extends Error {}

worker.onmessage = async ({ data: { file, packing, maxBytes } }) => {
  const parts = new BlobParts();
  let bytes = 0;
  let isBegun = false;
  try {
    await unpackStream(file, packing, (part) => {
      bytes += part.byteLength;
      if (bytes > maxBytes) throw new TooLarge();
      parts.add(part);
      if (isBegun || bytes < beginningBytes) return;
      isBegun = true;
      worker.postMessage({ beginning: parts.blob() });
    });
    worker.postMessage({ content: parts.blob() });
  } catch (error) {
    if (error instanceof TooLarge) {
      const most = `${Math.floor(maxBytes / 1e9)} GB`;
      const message = `expected at most ${most} in the ${packing}-compressed file, found more: build the store with the program (isosplat build)`;
      worker.postMessage({ status: "out_of_memory", message });
      return;
    }
    const reason = error instanceof Error ? error.message : String(error);
    const message = `the ${packing}-compressed data are damaged or not read here (${reason}): copy or download the file again, or unpack it with ${packing} -d`;
    worker.postMessage({ status: "malformed_volume", message });
  }
};
