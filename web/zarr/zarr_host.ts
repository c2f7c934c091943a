import type { AbsolutePath, RangeQuery } from "zarrita";
import type { FaultKind } from "../stream/faults.ts";
import { joined, Traffic, type TransferOptions, transfer } from "../stream/transfer.ts";
import { StreamError } from "../stream/types.ts";
import type { ZarrSource } from "./zarr_files.ts";

/** The largest size of metadata (bytes). */
export const maxMetadataBytes = 16 << 20;
/** The number of attempts to fetch a part. */
const maxTries = 4;
/** The wait after the first failure (ms); doubled each time. */
const firstWait = 500;

const metadataName = /\/(zarr\.json|\.z\w+)$/;

const lasting = new Set<FaultKind>(["not-found", "cors-refused", "access-denied", "out-of-memory"]);

/** The files of a Zarr hierarchy on a host. */
export class ZarrHost implements ZarrSource {
  readonly #base: URL;
  readonly #traffic = new Traffic();
  /** Each file of metadata is fetched once. */
  readonly #metadata = new Map<string, Promise<Uint8Array | undefined>>();
  absent = 0;
  maxBytes = maxMetadataBytes;

  constructor(base: URL) {
    this.#base = base;
  }

  get bytesReceived(): number {
    return this.#traffic.bytesReceived;
  }

  get(key: AbsolutePath): Promise<Uint8Array | undefined> {
    if (!metadataName.test(key)) return this.#fetch(key, {});
    const fetched = this.#metadata.get(key) ?? this.#fetch(key, {});
    this.#metadata.set(key, fetched);
    return fetched;
  }

  async getRange(key: AbsolutePath, range: RangeQuery): Promise<Uint8Array | undefined> {
    let offset: number;
    let bytes: number;
    if ("suffixLength" in range) {
      // For a request for the last bytes, browsers send a CORS preflight to hosts of other origins.
      const size = await this.#sizeOf(key);
      if (size === undefined) return undefined;
      bytes = Math.min(range.suffixLength, size);
      offset = size - bytes;
    } else {
      offset = range.offset;
      bytes = range.length;
    }
    if (bytes === 0) return new Uint8Array();
    if (bytes > this.maxBytes) throw this.#tooLarge(key);
    return this.#fetch(key, { range: [offset, offset + bytes - 1] });
  }

  #url(key: AbsolutePath): string {
    const url = new URL(this.#base);
    const names = key.split("/").filter((name) => name !== "");
    url.pathname = [url.pathname.replace(/\/+$/, ""), ...names.map(encodeURIComponent)].join("/");
    return url.href;
  }

  async #fetch(key: AbsolutePath, options: TransferOptions): Promise<Uint8Array | undefined> {
    const never = new AbortController().signal; // the worker is ended instead
    for (let tries = 1; ; ++tries) {
      const parts: Uint8Array[] = [];
      let received = 0;
      try {
        await transfer(this.#url(key), options, this.#traffic, never, (part) => {
          received += part.length;
          if (received > this.maxBytes) throw this.#tooLarge(key);
          parts.push(part);
        });
        return joined(parts);
      } catch (error) {
        if (!(error instanceof StreamError)) throw error;
        if (error.kind === "not-found") {
          ++this.absent;
          return undefined;
        }
        if (lasting.has(error.kind) || tries === maxTries) throw error;
        await new Promise((resolve) => setTimeout(resolve, firstWait * 2 ** (tries - 1)));
      }
    }
  }

  async #sizeOf(key: AbsolutePath): Promise<number | undefined> {
    const response = await fetch(this.#url(key), { method: "HEAD" });
    if (response.status === 404) return undefined;
    const length = response.headers.get("Content-Length");
    if (!response.ok || length === null) {
      throw new StreamError(
        "server-fault",
        `${this.#url(key)}: expected the size of a shard, found an answer ${response.status} without it`,
      );
    }
    return Number(length);
  }

  #tooLarge(key: AbsolutePath): StreamError {
    return new StreamError(
      "out-of-memory",
      `${this.#url(key)}: expected at most ${this.maxBytes} bytes, found more`,
    );
  }
}
