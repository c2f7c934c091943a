import { BlobParts } from "../core/blob_parts.ts";
import type { FaultKind } from "../stream/faults.ts";
import { Traffic, type TransferOptions, transfer } from "../stream/transfer.ts";
import { StreamError } from "../stream/types.ts";
import { deviceErrorTexts } from "../texts/device_errors.ts";
import { localized } from "../texts/numbers.ts";

/** Limit of the size of a file in bytes. The browser cannot build the volume of a larger file. */
export const maxFetchedBytes = 2 ** 32;
/** The download fails if its connection breaks more often than this. */
const maxBreaks = 5;
/** The wait before a broken connection is continued (ms); doubled each time. */
const firstWait = 500;

export interface FetchOptions {
  signal: AbortSignal;
  /** `bytes`: size of the whole file, if the host states it. */
  progress(received: number, bytes: number | undefined): void;
  /** Called with the file's version before its body arrives. True: the body is not needed. */
  isKnown?(version: string): boolean;
  /** Default: maxFetchedBytes. */
  maxBytes?: number;
}

export interface FetchedFile {
  /** Undefined if the version is known. */
  file: File | undefined;
  /** Identifies the version of the file. Undefined if the host does not state it. */
  version: string | undefined;
}

/** The description of the file in the header fields of a response. Hosts of other origins may hide fields (CORS). */
interface Identity {
  version: string | undefined;
  modified: number;
  bytes: number | undefined;
  /** The body is compressed on the network: its offsets are not those of the file. */
  isCoded: boolean;
}

/** Faults of the file itself, not of the connection. */
const final = new Set<FaultKind>(["replaced", "bad-address", "out-of-memory"]);

/** The names of the texts that state the remedy. */
const remedies = {
  "cors-refused": "corsRemedy",
  "not-found": "notFoundRemedy",
  "access-denied": "accessRemedy",
  unreachable: "unreachableRemedy",
  "server-fault": "serverRemedy",
} as const satisfies Partial<Record<FaultKind, keyof typeof deviceErrorTexts>>;

/**
 * Fetches a file into a Blob. After a broken connection, only the rest is requested if the host serves parts of
 * files and states the version of the file. Otherwise the whole file is requested again. Rejects with a StreamError,
 * whose message states the remedy, or with the signal's reason.
 */
export async function fetchFile(address: URL, options: FetchOptions): Promise<FetchedFile> {
  const { signal } = options;
  const fetching = new Fetching(address, options);
  for (let breaks = 0; ; ) {
    try {
      await fetching.next();
      return fetching.result();
    } catch (error) {
      signal.throwIfAborted();
      if (!(error instanceof StreamError) || final.has(error.kind)) throw error;
      const isBroken = error.kind === "unreachable" && fetching.hasAnswered;
      const isRefused = error.kind !== "unreachable" && fetching.isPart;
      if (!(isBroken || isRefused) || ++breaks > maxBreaks) throw explained(error);
      // If the host does not send the rest, the whole file is requested.
      if (isRefused || !fetching.canContinue) fetching.restart();
      await pause(firstWait * 2 ** (breaks - 1), signal);
    }
  }
}

/** The error with its remedy. */
export function explained(error: StreamError): StreamError {
  const { kind, message } = error;
  if (!(kind in remedies)) return error;
  const remedy = deviceErrorTexts[remedies[kind as keyof typeof remedies]];
  return new StreamError(kind, `${message}: ${remedy}.`, error);
}

function pause(ms: number, signal: AbortSignal): Promise<void> {
  return new Promise((resolve, reject) => {
    const ended = () => {
      clearTimeout(timer);
      reject(signal.reason);
    };
    const timer = setTimeout(() => {
      signal.removeEventListener("abort", ended);
      resolve();
    }, ms);
    signal.addEventListener("abort", ended, { once: true });
  });
}

class Fetching {
  readonly #address: URL;
  readonly #options: FetchOptions;
  readonly #traffic = new Traffic();
  #body = new BlobParts();
  #identity: Identity | undefined;
  #isKnown = false;
  received = 0;
  hasAnswered = false;

  constructor(address: URL, options: FetchOptions) {
    this.#address = address;
    this.#options = options;
  }

  /** Whether the last request was for the rest of the file. */
  isPart = false;

  /** Whether the rest of the file can be requested alone, without the part that has arrived. */
  get canContinue(): boolean {
    const { version, bytes, isCoded } = this.#identity ?? {};
    return version !== undefined && bytes !== undefined && !isCoded && this.received < bytes;
  }

  restart(): void {
    this.#body = new BlobParts();
    this.#identity = undefined;
    this.received = 0;
  }

  async next(): Promise<void> {
    const { signal, progress, maxBytes = maxFetchedBytes } = this.#options;
    const ending = new AbortController();
    const last = (this.#identity?.bytes ?? 0) - 1;
    this.isPart = this.received > 0 && this.canContinue;
    const request: TransferOptions = {
      identify: (_, headers) => {
        this.#identify(headers);
        if (this.#isKnown) ending.abort();
      },
      ...(this.isPart ? { range: [this.received, last] as const } : {}),
    };
    const either = AbortSignal.any([signal, ending.signal]);
    try {
      await transfer(this.#address.href, request, this.#traffic, either, (part) => {
        this.received += part.length;
        if (this.received > maxBytes) throw this.#tooLarge(this.received);
        this.#body.add(part);
        progress(this.received, this.#identity?.bytes);
      });
    } catch (error) {
      if (!this.#isKnown) throw error;
    }
  }

  result(): FetchedFile {
    const { version, modified = 0 } = this.#identity ?? {};
    if (this.#isKnown) return { file: undefined, version };
    const file = new File([this.#body.blob()], nameAt(this.#address), { lastModified: modified });
    return { file, version };
  }

  #identify(headers: Headers): void {
    const { isKnown, maxBytes = maxFetchedBytes } = this.#options;
    const { href } = this.#address;
    const type = headers.get("Content-Type");
    if (type?.startsWith("text/html")) {
      throw new StreamError("bad-address", deviceErrorTexts.webPage(href, type));
    }
    const found = identityOf(headers);
    this.hasAnswered = true;
    if (this.isPart) {
      if (found.version !== this.#identity?.version) {
        throw new StreamError("replaced", deviceErrorTexts.replaced(href));
      }
      return;
    }
    this.#identity = found;
    if ((found.bytes ?? 0) > maxBytes) throw this.#tooLarge(found.bytes ?? 0);
    this.#isKnown = found.version !== undefined && (isKnown?.(found.version) ?? false);
  }

  #tooLarge(bytes: number): StreamError {
    const gb = (n: number) => localized(`${(n / 1e9).toFixed(1)} GB`);
    const { maxBytes = maxFetchedBytes } = this.#options;
    const name = nameAt(this.#address);
    const text = deviceErrorTexts.tooLarge(name, gb(maxBytes), gb(bytes));
    return new StreamError("out-of-memory", text);
  }
}

function identityOf(headers: Headers): Identity {
  const modified = headers.get("Last-Modified");
  const version = [headers.get("ETag"), modified].filter((each) => each !== null).join(" ");
  const isCoded = headers.has("Content-Encoding");
  const length = headers.get("Content-Length");
  return {
    version: version || undefined,
    modified: (modified && Date.parse(modified)) || 0,
    bytes: length === null || isCoded ? undefined : Number(length),
    isCoded,
  };
}

/** The name of the file at an address. */
export function nameAt(address: URL): string {
  return pathAt(address).split("/").pop() || "volume";
}

/** The path of an address, decoded, without the first "/". */
export function pathAt({ pathname }: URL): string {
  const path = pathname.replace(/^\/+/, "");
  try {
    return decodeURIComponent(path);
  } catch {
    return path; // a % that is not a valid escape
  }
}
