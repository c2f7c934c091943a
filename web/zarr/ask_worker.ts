import { messageOfLoss, startWorker } from "../core/page_worker.ts";
import { StreamError } from "../stream/types.ts";
import { ZarrError } from "./image_axes.ts";
import type { ZarrImage, ZarrScale, ZarrVoxels } from "./types.ts";
import type { FilesByPath } from "./zarr_files.ts";
import type { ZarrRequest, ZarrResponse } from "./zarr_worker.ts";

/**
 * Reads the metadata of an image, of one of its scales, or of an array. `files`: those of this device,
 * if `address` is that of a folder among them (`addressOfFolder`). Rejects with a ZarrError, a
 * StreamError, or the signal's reason.
 */
export async function openZarr(
  address: string,
  signal: AbortSignal,
  files?: FilesByPath,
): Promise<ZarrImage> {
  const answer = await ask({ open: address, files }, signal);
  if (!("image" in answer)) throw unexpected();
  return { ...answer.image, files };
}

/**
 * Reads the voxels of a scale. `progress` is called with the fraction read so far. Rejects like
 * openZarr.
 */
export async function readZarr(
  { address, files }: ZarrImage,
  scale: ZarrScale,
  { signal, progress }: { signal: AbortSignal; progress?(fraction: number): void },
): Promise<ZarrVoxels> {
  const answer = await ask({ read: scale, address, files }, signal, progress);
  if (!("voxels" in answer)) throw unexpected();
  return answer;
}

function unexpected(): ZarrError {
  return new ZarrError("expected another answer of the worker: load the page again");
}

/** A worker for one request, which ends after its reply or by the signal. */
async function ask(
  request: ZarrRequest,
  signal: AbortSignal,
  progress?: (fraction: number) => void,
): Promise<ZarrResponse> {
  signal.throwIfAborted();
  const worker = startWorker(
    "zarr_worker.js",
    () => new Worker(new URL("./zarr_worker.ts", import.meta.url), { type: "module" }),
  );
  let abort = (): void => {};
  try {
    return await new Promise<ZarrResponse>((resolve, reject) => {
      abort = () => reject(signal.reason);
      signal.addEventListener("abort", abort, { once: true });
      worker.onerror = (event) => {
        event.preventDefault();
        reject(new ZarrError(messageOfLoss(worker, event)));
      };
      worker.onmessage = ({ data }: MessageEvent<ZarrResponse>) => {
        if ("progress" in data) progress?.(data.progress);
        else if (!("message" in data)) resolve(data);
        else if (data.fault) reject(new StreamError(data.fault, data.message));
        else reject(new ZarrError(data.message));
      };
      worker.postMessage(request);
    });
  } finally {
    signal.removeEventListener("abort", abort);
    worker.terminate();
  }
}
