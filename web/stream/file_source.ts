import { maxHeaderBytes } from "../core/core.ts";
import { RangeSource } from "./range_source.ts";
import {
  type Admittance,
  beginsAsStore,
  type FileIdentity,
  joined,
  Traffic,
  transfer,
} from "./transfer.ts";
import { StreamError } from "./types.ts";
import { fetchWhole } from "./whole_file.ts";

/** Bytes of the first request for the header. Most headers are much smaller than their limit. */
const firstHeaderBytes = 16 * 1024;
/** The offset of the content id in the header (shared/core/store/FORMAT.md). */
const contentIdRange = [32, 48] as const;

export interface SourceOptions extends Admittance {
  /** A connection counts as broken after this time without data (ms). Default: 20 s. */
  longestSilence?: number;
}

/**
 * A store as one file on any host that answers HTTP Range requests. From other hosts, small stores are
 * fetched as a whole, with a warning.
 */
export class FileSource extends RangeSource {
  readonly name: string;
  protected readonly traffic = new Traffic();
  #fresh = false;
  #warm: { header: Promise<Uint8Array>; whole: boolean } | undefined;
  /**
   * The file's identity according to earlier responses. `#etagIdentifies`: whether a different ETag
   * means a different file.
   */
  #etag: string | undefined;
  #fileBytes: number | undefined;
  #etagIdentifies = true;
  /** The whole file, if its host does not serve parts of it. */
  #whole: Promise<Uint8Array> | undefined;
  #hasWarned = false;

  constructor(url: string, options: SourceOptions = {}) {
    super();
    this.name = url;
    const { headers, credentials, query } = options;
    this.traffic.admittance = {
      ...(headers && { headers: { ...headers } }),
      ...(credentials && { credentials }),
      ...(query && { query }),
    };
    if (options.longestSilence) this.traffic.longestSilence = options.longestSilence;
  }

  get address(): string | undefined {
    const page = typeof location === "undefined" ? undefined : location.href;
    const url = this.fileUrl();
    return URL.canParse(url, page) ? new URL(url, page).href : undefined;
  }

  get concurrency(): number {
    return 6;
  }

  get requests(): number {
    return this.traffic.requests;
  }

  get bytesReceived(): number {
    return this.traffic.bytesReceived;
  }

  get fileBytes(): number | undefined {
    return this.#fileBytes;
  }

  bypassCaches(): void {
    this.#fresh = true;
  }

  forget(): void {
    this.#warm = undefined;
    this.#etag = undefined;
    this.#fileBytes = undefined;
    this.#fresh = false;
    this.#whole = undefined;
  }

  async contentId(signal: AbortSignal): Promise<string> {
    const before = { etag: this.#etag, bytes: this.#fileBytes };
    this.#etag = undefined;
    this.#fileBytes = undefined;
    const [, end] = contentIdRange;
    try {
      const header: Uint8Array[] = [];
      await this.#request([0, end - 1], signal, (part) => header.push(part), true);
      const bytes = joined(header);
      if (!beginsAsStore(bytes)) {
        throw new StreamError(
          "not-a-store",
          `${this.name}: expected a store, found something else`,
        );
      }
      // Hosts that consist of several machines may send different ETags for the same file.
      const isOtherEtag = before.etag !== undefined && this.#etag !== before.etag;
      if (isOtherEtag && before.bytes === this.#fileBytes) this.#etagIdentifies = false;
      return contentIdOf(bytes);
    } catch (error) {
      this.#etag = before.etag;
      this.#fileBytes = before.bytes;
      throw error;
    }
  }

  /** Checks that a response belongs to the file that was opened. */
  readonly #identify = ({ etag, bytes }: FileIdentity): void => {
    const isOther =
      (bytes !== undefined && this.#fileBytes !== undefined && bytes !== this.#fileBytes) ||
      (this.#etagIdentifies &&
        etag !== undefined &&
        this.#etag !== undefined &&
        etag !== this.#etag);
    if (isOther) {
      throw new StreamError(
        "replaced",
        `${this.name}: expected the file that was opened (${this.#fileBytes} bytes, ETag ` +
          `${this.#etag}), found another (${bytes} bytes, ETag ${etag})`,
      );
    }
    this.#etag ??= etag;
    this.#fileBytes ??= bytes;
  };

  /**
   * Call it when the file was read again and proved to be the same. From then on, its ETag is
   * ignored.
   */
  isSame(): void {
    this.#etagIdentifies = false;
  }

  get fresh(): boolean {
    return this.#fresh;
  }

  protected fileUrl(): string {
    return this.name;
  }

  warm(): void {
    if (this.#warm) return;
    const header = this.fetchHeader(new AbortController().signal, this.fresh);
    // header() reports a failure.
    header.catch(() => {});
    this.#warm = { header, whole: this.fresh };
  }

  async header(signal: AbortSignal, whole = false): Promise<Uint8Array> {
    const warm = this.#warm;
    this.#warm = undefined;
    if (warm && (warm.whole || !whole)) {
      try {
        return await warm.header;
      } finally {
        signal.throwIfAborted();
      }
    }
    return this.fetchHeader(signal, whole);
  }

  protected fetchHeader(signal: AbortSignal, whole: boolean): Promise<Uint8Array> {
    return this.firstBytes(whole ? maxHeaderBytes : firstHeaderBytes, signal);
  }

  /** The first bytes of the file: `count`, or all of a smaller file. */
  async firstBytes(count: number, signal: AbortSignal): Promise<Uint8Array> {
    const parts: Uint8Array[] = [];
    await this.#request([0, count - 1], signal, (part) => parts.push(part));
    return joined(parts);
  }

  async range(
    offset: number,
    bytes: number,
    signal: AbortSignal,
    arrived: (part: Uint8Array, offset: number) => void,
  ): Promise<void> {
    let at = offset;
    await this.#request([offset, offset + bytes - 1], signal, (part) => {
      arrived(part, at);
      at += part.length;
    });
    // The response is complete according to its headers, so the file ends here.
    if (at !== offset + bytes) {
      throw new StreamError(
        "cut-short",
        `${this.name}: expected ${bytes} bytes from ${offset}, found ${at - offset}` +
          `${this.#fileBytes === undefined ? "" : ` of a file of ${this.#fileBytes}`}: the file ` +
          "was cut short",
      );
    }
  }

  async #request(
    range: readonly [first: number, last: number],
    signal: AbortSignal,
    arrived: (part: Uint8Array) => void,
    fresh = this.fresh,
  ): Promise<void> {
    if (this.#whole && !fresh) return this.#readWhole(range, signal, arrived);
    const options = { range, fresh, identify: this.#identify };
    try {
      await transfer(this.fileUrl(), options, this.traffic, signal, arrived);
    } catch (error) {
      if (!(error instanceof StreamError) || error.kind !== "no-range") throw error;
      if (fresh) this.#whole = undefined;
      await this.#readWhole(range, signal, arrived, fresh);
    }
  }

  async #readWhole(
    [first, last]: readonly [first: number, last: number],
    signal: AbortSignal,
    arrived: (part: Uint8Array) => void,
    fresh = false,
  ): Promise<void> {
    if (!this.#whole) {
      const options = { fresh, identify: this.#identify };
      const whole = fetchWhole(this.fileUrl(), options, this.traffic);
      this.#whole = whole;
      whole.then(
        () => this.#warnOfWhole(),
        () => {
          if (this.#whole === whole) this.#whole = undefined;
        },
      );
    }
    const bytes = await this.#whole;
    signal.throwIfAborted();
    if (first < bytes.length) arrived(bytes.subarray(first, last + 1));
  }

  #warnOfWhole(): void {
    if (this.#hasWarned) return;
    this.#hasWarned = true;
    console.warn(
      `${this.name}: this host does not serve parts of files (HTTP Range): the store was fetched whole`,
    );
  }
}

/** The content id in the first bytes of a store. */
export function contentIdOf(header: Uint8Array): string {
  return hexadecimal(header.subarray(...contentIdRange));
}

export function hexadecimal(bytes: Uint8Array): string {
  return Array.from(bytes, (byte) => byte.toString(16).padStart(2, "0")).join("");
}
