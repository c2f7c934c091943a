import { CoreError } from "../core/calls.ts";
import { messageOfLoss, startWorker } from "../core/page_worker.ts";
import type { InputFile, Packing } from "./types.ts";
import type { UnpackRequest, UnpackResponse } from "./unpack_worker.ts";

/** The largest decompressed size (bytes). The browser cannot build larger volumes. */
export const maxUnpackedBytes = 2 ** 32;

/**
 * Decompresses a file. `accepts` is called with the beginning of the content. If it resolves with
 * false, the rest is not decompressed, and the result is undefined. Rejects with a CoreError or the
 * signal's reason.
 */
export async function unpackFile(
  { path, file }: InputFile,
  packing: Packing,
  accepts: (beginning: Blob) => Promise<boolean>,
  signal?: AbortSignal,
): Promise<Blob | undefined> {
  signal?.throwIfAborted();
  const worker = startWorker(
    "unpack_worker.js",
    () => new Worker(new URL("./unpack_worker.ts", import.meta.url), { type: "module" }),
  );
  let abort = (): void => {};
  try {
    return await new Promise<Blob | undefined>((resolve, reject) => {
      abort = () => reject(signal?.reason);
      signal?.addEventListener("abort", abort, { once: true });
      const fail = (status: string, message: string) =>
        reject(new CoreError(status, `${path}: ${message}`));
      worker.onerror = (event) => {
        event.preventDefault();
        fail("worker_lost", messageOfLoss(worker, event));
      };
      let isAccepted: Promise<boolean> = Promise.resolve(true);
      worker.onmessage = ({ data }: MessageEvent<UnpackResponse>) => {
        if ("beginning" in data) {
          isAccepted = accepts(data.beginning);
          isAccepted.then((is) => is || resolve(undefined), reject);
        } else if ("content" in data) {
          isAccepted.then((is) => resolve(is ? data.content : undefined), reject);
        } else fail(data.status, data.message);
      };
      worker.postMessage({ file, packing, maxBytes: maxUnpackedBytes } satisfies UnpackRequest);
    });
  } finally {
    signal?.removeEventListener("abort", abort);
    worker.terminate();
  }
}
