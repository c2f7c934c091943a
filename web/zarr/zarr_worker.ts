/** A worker for one request: it opens an image, or reads one scale of it. */
import { open, root } from "zarrita";
import { BlobParts } from "../core/blob_parts.ts";
import type { FaultKind } from "../stream/faults.ts";
import { StreamError } from "../stream/types.ts";
import { replaceCodecs } from "./codecs.ts";
import { openImage } from "./open_image.ts";
import { planReading, readScale } from "./read_scale.ts";
import type { ZarrImage, ZarrScale, ZarrVoxels } from "./types.ts";
import { ZarrHost } from "./zarr_host.ts";

export type ZarrRequest = { open: string } | { read: ZarrScale; address: string };

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

async function read(scale: ZarrScale, address: string): Promise<ZarrVoxels> {
  const host = new ZarrHost(new URL(address));
  const array = await open(root(host).resolve(scale.path), { kind: "array" });
  const { chunks, chunkBytes } = planReading(scale, array.chunks);
  host.maxBytes = 2 * chunkBytes + surplus;
  host.absent = 0;
  const slices = new BlobParts();
  let reportedAt = 0;
  const progress = (fraction: number) => {
    if (performance.now() - reportedAt < progressEvery) return;
    reportedAt = performance.now();
    worker.postMessage({ progress: fraction });
  };
  await readScale(array, scale, (layer) => slices.add(layer), progress);
  const notes =
    host.absent > 0
      ? [`${host.absent} of ${chunks} chunks are absent: their voxels have the fill value`]
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
    if ("open" in data) worker.postMessage({ image: await openImage(data.open) });
    else worker.postMessage(await read(data.read, data.address));
  } catch (error) {
    worker.postMessage(failure(error));
  }
};
