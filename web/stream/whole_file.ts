import { joined, type Traffic, type TransferOptions, transfer } from "./transfer.ts";
import { StreamError } from "./types.ts";

/**
 * A store of at most this size is fetched as a whole from a host that does not serve parts of files.
 */
export const maxWholeBytes = 16 * 1024 * 1024;

/**
 * Fetches a file without a Range request. The request is not aborted, because several callers may wait
 * for parts of the file. Rejects with a StreamError: "no-range" if the file is too large for this.
 */
export async function fetchWhole(
  url: string,
  options: Omit<TransferOptions, "range">,
  traffic: Traffic,
): Promise<Uint8Array> {
  const parts: Uint8Array[] = [];
  let received = 0;
  const check = (bytes: number): void => {
    if (bytes <= maxWholeBytes) return;
    throw new StreamError(
      "no-range",
      `${url}: the host does not serve parts of files, and a store of ${bytes} bytes or more is not ` +
        `fetched whole (at most ${maxWholeBytes}). Check that the host supports HTTP Range requests`,
    );
  };
  const identify: TransferOptions["identify"] = (answer, headers) => {
    check(answer.bytes ?? 0);
    options.identify?.(answer, headers);
  };
  await transfer(url, { ...options, identify }, traffic, new AbortController().signal, (part) => {
    received += part.length;
    check(received);
    parts.push(part);
  });
  return joined(parts);
}
