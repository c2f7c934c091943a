import { isOfPart } from "./faults.ts";
import { contentIdOf, FileSource, hexadecimal, type SourceOptions } from "./file_source.ts";
import { FrameReader } from "./frames.ts";
import { together } from "./range_source.ts";
import { type ChunkPlaceInFile, PartError } from "./source.ts";
import { TransferError, transfer, transferWhole, withQuery } from "./transfer.ts";
import { StreamError } from "./types.ts";

/**
 * The intended duration of a batch (ms); after each batch, the priorities are reconsidered. The size of
 * a batch is computed from the measured rate of the last batches, within these limits.
 */
const batchTime = 250;
const [fewestBatchBytes, maxBatchBytes] = [128 * 1024, 1024 * 1024];
/** Keeps the batch's URL below 2 KB. */
const batchChunks = 96;

export interface ServerSourceOptions extends SourceOptions {
  /** The server's address. Default: the page's address. */
  base?: string;
  /** The volume's name on the server. */
  volume: string;
}

/**
 * A volume of an Isosplat server (server/HTTP.md). Except for the volume's URL, all URLs contain
 * the content id, so their content never changes. Over HTTP/1.1, one streamed response carries many
 * chunks. Over HTTP/2 and later, each chunk has its own request: these are multiplexed, and cached
 * separately.
 */
export class ServerSource extends FileSource {
  override get concurrency(): number {
    return this.#multiplexed ? 16 : 2;
  }
  readonly #volumeUrl: string;
  #contentUrl: string | undefined;
  /** The chunks and pages that came with the header, until they are requested. */
  #bootstrap: Bootstrap | undefined;
  #multiplexed = false;
  #batchBytes = 192 * 1024;

  constructor(options: ServerSourceOptions) {
    super(options.volume, options);
    const page = typeof location === "undefined" ? undefined : location.href;
    const base = new URL(options.base ?? ".", page).href.replace(/\/*$/, "/");
    this.#volumeUrl = `${base}v1/volumes/${encodeURIComponent(options.volume)}`;
  }

  override get address(): string {
    return this.#volumeUrl;
  }

  override forget(): void {
    super.forget();
    this.#contentUrl = undefined;
    this.#bootstrap = undefined;
  }

  override async contentId(signal: AbortSignal): Promise<string> {
    const options = { fresh: true };
    const answer = await ofVolume(
      transferWhole(this.#volumeUrl, options, this.traffic, signal),
      this.#volumeUrl,
    );
    try {
      const { contentId } = JSON.parse(new TextDecoder().decode(answer)) as { contentId?: unknown };
      if (typeof contentId === "string") return contentId;
    } catch {} // reported below
    throw new StreamError(
      "server-fault",
      `${this.#volumeUrl}: expected the server's description of the volume, found something else`,
    );
  }

  protected override async fetchHeader(signal: AbortSignal): Promise<Uint8Array> {
    const options = { fresh: this.fresh };
    if (this.#contentUrl) {
      const url = `${this.#contentUrl}/header`;
      return ofVolume(transferWhole(url, options, this.traffic, signal), url);
    }
    const url = `${this.#volumeUrl}/bootstrap`;
    const answer = await ofVolume(transferWhole(url, options, this.traffic, signal), url);
    const bootstrap = this.#checked(() => readBootstrap(answer, url));
    this.#contentUrl = `${this.#volumeUrl}/${bootstrap.contentId}`;
    this.#multiplexed = isMultiplexed(withQuery(url, this.traffic.admittance.query));
    this.#bootstrap = bootstrap;
    return bootstrap.header;
  }

  override async range(
    offset: number,
    bytes: number,
    signal: AbortSignal,
    arrived: (part: Uint8Array, offset: number) => void,
  ): Promise<void> {
    const bootstrap = this.#bootstrap;
    this.#bootstrap = undefined;
    if (bootstrap && offset === bootstrap.offset && bytes <= bootstrap.rest.length) {
      arrived(bootstrap.rest.subarray(0, bytes), offset);
      return;
    }
    await super.range(offset, bytes, signal, arrived);
  }

  override async chunks<C extends ChunkPlaceInFile>(
    chunks: readonly C[],
    signal: AbortSignal,
    arrived: (chunk: C, bytes: Uint8Array) => void,
  ): Promise<void> {
    const options = { fresh: this.fresh };
    if (this.#multiplexed || chunks.length === 1) {
      await together(signal, this.concurrency, chunks, async (chunk, ending) => {
        const url = `${this.#contentUrl}/chunks/${chunkPath(chunk)}`;
        const bytes = await transferWhole(url, options, this.traffic, ending);
        if (!ending.aborted) arrived(chunk, bytes);
      });
      return;
    }
    const url = `${this.#contentUrl}/batch?chunks=${chunks.map(chunkPath).join(",")}`;
    const frames = new FrameReader(chunks, arrived);
    const begin = performance.now();
    try {
      await transfer(url, options, this.traffic, signal, (part) =>
        this.#checked(() => frames.add(part)),
      );
    } catch (error) {
      const [first] = chunks;
      if (!(first && error instanceof TransferError && error.isOfStore)) throw error;
      // The first chunk has failed. If a later one had failed, the response would begin with
      // frames.
      throw new PartError(first.handle, error.message);
    }
    frames.end();
    const bytes = chunks.reduce((sum, chunk) => sum + chunk.bytes, 0);
    const fitting = (bytes * batchTime) / Math.max(1, performance.now() - begin);
    // A small batch measures the round trip, not the rate of the link.
    if (bytes >= fewestBatchBytes / 2 || fitting > this.#batchBytes) {
      const next = (this.#batchBytes + fitting) / 2;
      this.#batchBytes = Math.min(maxBatchBytes, Math.max(fewestBatchBytes, next));
    }
  }

  /**
   * Parses a response. After a failure, later requests bypass caches, because a cache may have sent it.
   */
  #checked<T>(read: () => T): T {
    try {
      return read();
    } catch (error) {
      if (!(error instanceof PartError)) this.bypassCaches();
      throw error;
    }
  }

  override group<C extends ChunkPlaceInFile>(chunks: readonly C[]): C[][] {
    if (this.#multiplexed) return chunks.map((chunk) => [chunk]);
    const groups: C[][] = [];
    let bytes = 0;
    for (const chunk of chunks) {
      const last = groups.at(-1);
      if (last && bytes + chunk.bytes <= this.#batchBytes && last.length < batchChunks) {
        last.push(chunk);
        bytes += chunk.bytes;
      } else {
        groups.push([chunk]);
        bytes = chunk.bytes;
      }
    }
    return groups;
  }

  protected override fileUrl(): string {
    return `${this.#contentUrl}/file`;
  }
}

/** Reports a damaged part of the header or of the bootstrap response as a damaged header. */
async function ofVolume(answer: Promise<Uint8Array>, url: string): Promise<Uint8Array> {
  try {
    return await answer;
  } catch (error) {
    if (!(error instanceof StreamError) || !isOfPart(error.kind)) throw error;
    throw new StreamError("damaged-header", `${url}: ${error.message}`, error);
  }
}

function chunkPath(chunk: ChunkPlaceInFile): string {
  return `${chunk.level}/${chunk.block.join(".")}/${chunk.band}`;
}

/** The bootstrap response, which opens a volume (server/HTTP.md). */
interface Bootstrap {
  contentId: string;
  header: Uint8Array;
  /** A byte range of the file, and its offset. */
  rest: Uint8Array;
  offset: number;
}

const bootstrapHeaderBytes = 32;

function readBootstrap(answer: Uint8Array, url: string): Bootstrap {
  const view = new DataView(answer.buffer, answer.byteOffset, answer.byteLength);
  const words = answer.length < bootstrapHeaderBytes ? 0 : 4;
  const [headerBytes = 0, restBytes = 0, low = 0, high = 0] = Array.from(
    { length: words },
    (_, i) => view.getUint32(4 * i, true),
  );
  const headerEnd = bootstrapHeaderBytes + headerBytes;
  if (words === 0 || headerEnd + restBytes !== answer.length) {
    throw new StreamError(
      "server-fault",
      `${url}: expected the volume's header and coarse levels, found ${answer.length} bytes of ` +
        "something else: is it an Isosplat server?",
    );
  }
  const contentId = hexadecimal(answer.subarray(16, bootstrapHeaderBytes));
  const header = answer.subarray(bootstrapHeaderBytes, headerEnd);
  if (contentIdOf(header) !== contentId) {
    throw new StreamError(
      "server-fault",
      `${url}: expected the header of ${contentId}, found that of ${contentIdOf(header)}: the bytes ` +
        "were changed in transit",
    );
  }
  return {
    contentId,
    header,
    rest: answer.subarray(headerEnd),
    offset: low + high * 2 ** 32,
  };
}

/** Whether the connection multiplexes requests (HTTP/2 or later), according to the browser. */
function isMultiplexed(url: string): boolean {
  if (typeof performance === "undefined" || typeof window === "undefined") return false;
  const [entry] = performance.getEntriesByName(url, "resource").slice(-1);
  const protocol = (entry as PerformanceResourceTiming | undefined)?.nextHopProtocol ?? "";
  return protocol === "h2" || protocol === "h3";
}
