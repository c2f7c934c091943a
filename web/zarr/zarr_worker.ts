/** A worker for one request: it opens an image, or reads one scale of it. */
import { open, root } from "zarrita";
import { BlobParts } from "../core/blob_parts.ts";
import type { FaultKind } from "../stream/faults.ts";
import { StreamError } from "../stream/types.ts";
import { replaceCodecs } from "./codecs.ts";
import { openImage } from "./open_image.ts";
import { planReading, readScale } from "./read_scale.ts";
import type { ZarrImage, ZarrScale, ZarrVoxels } from "./types.ts";
import { type FilesByPath, zarrSource } from "./zarr_files.ts";

/** `files`: those of this device, for the address of a folder among them. */
export type ZarrRequest = ({ open: string } | { read: ZarrScale; address: string }) & {
  files?: FilesByPath | undefined;
};

export type ZarrResponse =
  | { image: ZarrImage }
  | { progress: number }
  | ZarrVoxels
  | { message: string; fault: FaultKind | undefined };

/** The shortest time between two reports of progress (ms). */
const progressEvery = 100;
/** A compressed chunk may be larger than its voxels by this number of bytes. */
const surplus = 1 << 20;

const worker = globalThis as unknown as {
  onmessage: ((event: MessageEvent<ZarrRequest>) => void) | null;
  postMessage(message: ZarrResponse): void;
};

async function read(
  scale: ZarrScale,
  address: string,
  files: FilesByPath | undefined,
): Promise<ZarrVoxels> {
  const source = zarrSource(new URL(address), files);
  const array = await open(root(source).resolve(scale.path), { kind: "array" });
  const { chunks, chunkBytes } = planReading(scale, array.chunks);
  source.maxBytes = 2 * chunkBytes + surplus;
  source.absent = 0;
  const slices = new BlobParts();
  let reportedAt = 0;
  const progress = (fraction: number) => {
    if (performance.now() - reportedAt < progressEvery) return;
    reportedAt = performance.now();
    worker.postMessage({ progress: fraction });
  };
  await readScale(array, scale, (layer) => slices.add(layer), progress);
  const notes =
    source.absent > 0
      ? [`${source.absent} of ${chunks} chunks are absent: their voxels have the fill value`]
      : [];
  return { voxels: slices.blob(), notes };
}

function failure(error: unknown): Extract<ZarrResponse, { message: string }> {
  const { message, cause } = error as Error;
  const isFault = error instanceof StreamError;
  const reason = !isFault && cause instanceof Error ? `: ${cause.message}` : "";
  return { message: `${message}${reason}`, fault: isFault ? error.kind : undefined };
}

replaceCodecs();
worker.onmessage = async ({ data }) => {
  try {
    if ("open" in data) worker.postMessage({ image: await openImage(data.open, data.files) });
    else worker.postMessage(await read(data.read, data.address, data.files));
  } catch (error) {
    worker.postMessage(failure(error));
  }
};
