import { faultOfCode, faultOfStatus } from "./faults.ts";
import { StreamError } from "./types.ts";

/** The credentials that a source sends to its host. */
export interface Admittance {
  /**
   * Header fields of every request, such as `{ Authorization: "Bearer …" }`. A host of another
   * origin has to allow them (`Access-Control-Allow-Headers`).
   */
  headers?: Readonly<Record<string, string>>;
  /**
   * Whether cookies are sent, as for `fetch`. Default: "same-origin". For "include", a host of another
   * origin has to send `Access-Control-Allow-Credentials: true` and the page's origin.
   */
  credentials?: RequestInit["credentials"];
  /** Added to the query of every URL: a signed link's `exp=…&sig=…`, for example. */
  query?: string;
}

/** Counts the requests and received bytes of one source. */
export class Traffic {
  admittance: Admittance = {};
  requests = 0;
  bytesReceived = 0;
  /** Whether the source has responded, and CORS allows this page to read its responses. */
  hasAnswered = false;
  /** A connection counts as broken after this time without data (ms). */
  longestSilence = 20_000;
}

export interface TransferOptions {
  /** First and last byte to request. */
  range?: readonly [first: number, last: number];
  /** Bypasses all caches, because a cached response was wrong. */
  fresh?: boolean;
  /**
   * Called before the body arrives, with the identity of the file according to the headers. If it
   * throws, the request ends.
   */
  identify?: (answer: FileIdentity, headers: Headers) => void;
}

/**
 * The identity of a file according to the headers of a response. A field is undefined if its header
 * is missing or hidden by CORS.
 */
export interface FileIdentity {
  etag: string | undefined;
  /** Size of the whole file. */
  bytes: number | undefined;
}

/** The StreamError of a failed request, and the wait that the server requests (Retry-After), in ms. */
export class TransferError extends StreamError {
  retryAfter = 0;
  /** An Isosplat server cannot read the requested part from its store. */
  isOfStore = false;
}

/** Most bytes that are read from the body of an error response. */
const longestExplanation = 16 * 1024;
/** The first bytes of every store (shared/core/store/FORMAT.md) and bundle (shared/core/scene/BUNDLE.md). */
const storeMagic = [0x89, 0x49, 0x53, 0x4f, 0x53, 0x0d, 0x0a, 0x1a];
const bundleMagic = [0x89, 0x49, 0x53, 0x4f, 0x42, 0x0d, 0x0a, 0x1a];

/**
 * Makes one request and passes on the response's body as it arrives. Rejects unless the body has
 * exactly the size that the range or Content-Length states. Adds to `traffic`. Rejects with a
 * StreamError or the signal's reason.
 */
export async function transfer(
  url: string,
  options: TransferOptions,
  traffic: Traffic,
  signal: AbortSignal,
  arrived: (part: Uint8Array) => void,
): Promise<void> {
  signal.throwIfAborted();
  const silence = new Silence(signal, traffic.longestSilence);
  try {
    const response = await send(url, options, traffic, signal, silence);
    try {
      await check(response, url, options);
      const wanted = identify(response, url, options);
      await read(response, url, { ...options, wanted }, traffic, (part) => {
        silence.restart();
        arrived(part);
      });
    } catch (cause) {
      // The rest of the body is not needed: release the connection.
      void response.body?.cancel().catch(() => {});
      throw cause;
    }
  } catch (cause) {
    signal.throwIfAborted();
    if (cause instanceof StreamError) throw cause;
    const what = silence.isOver
      ? `nothing has arrived for ${traffic.longestSilence / 1000} s`
      : "the connection broke";
    throw new TransferError("unreachable", `${url}: ${what}`, cause);
  } finally {
    silence.end();
  }
}

/** `url` with `query` at the end of its query. */
export function withQuery(url: string, query: string | undefined): string {
  return query ? `${url}${url.includes("?") ? "&" : "?"}${query}` : url;
}

/** Like `transfer`, but returns the whole body as one array. */
export async function transferWhole(
  url: string,
  options: TransferOptions,
  traffic: Traffic,
  signal: AbortSignal,
): Promise<Uint8Array> {
  const parts: Uint8Array[] = [];
  await transfer(url, options, traffic, signal, (part) => parts.push(part));
  return joined(parts);
}

export function joined(parts: readonly Uint8Array[]): Uint8Array {
  const [first] = parts;
  if (parts.length === 1 && first) return first;
  const whole = new Uint8Array(parts.reduce((bytes, part) => bytes + part.length, 0));
  let at = 0;
  for (const part of parts) {
    whole.set(part, at);
    at += part.length;
  }
  return whole;
}

/** Whether these are the first bytes of a store. */
export function beginsAsStore(bytes: Uint8Array): boolean {
  return storeMagic.every((byte, i) => bytes[i] === byte);
}

/** Whether these are the first bytes of a bundle. */
export function beginsAsBundle(bytes: Uint8Array): boolean {
  return bundleMagic.every((byte, i) => bytes[i] === byte);
}

/** Aborts a request when its signal is aborted, or when no data have arrived for too long. */
class Silence {
  readonly #ending = new AbortController();
  readonly #outer: AbortSignal;
  readonly #aborted = (): void => this.#ending.abort(this.#outer.reason);
  #timer: ReturnType<typeof setTimeout> | undefined;
  isOver = false;
  readonly #longest: number;

  constructor(outer: AbortSignal, longest: number) {
    this.#outer = outer;
    this.#longest = longest;
    outer.addEventListener("abort", this.#aborted, { once: true });
    this.restart();
  }

  get signal(): AbortSignal {
    return this.#ending.signal;
  }

  /** Call it when data have arrived. */
  restart(): void {
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => {
      this.isOver = true;
      this.#ending.abort(new DOMException("nothing has arrived for too long", "TimeoutError"));
    }, this.#longest);
  }

  end(): void {
    clearTimeout(this.#timer);
    this.#outer.removeEventListener("abort", this.#aborted);
  }
}

async function send(
  url: string,
  options: TransferOptions,
  traffic: Traffic,
  signal: AbortSignal,
  silence: Silence,
): Promise<Response> {
  ++traffic.requests;
  const { credentials = "same-origin" } = traffic.admittance;
  const headers: Record<string, string> = { ...traffic.admittance.headers };
  if (options.range) headers.Range = `bytes=${options.range[0]}-${options.range[1]}`;
  try {
    const cache = options.fresh ? "reload" : "default";
    const address = withQuery(url, traffic.admittance.query);
    const response = await fetch(address, { headers, credentials, signal: silence.signal, cache });
    silence.restart();
    traffic.hasAnswered = true;
    return response;
  } catch (cause) {
    signal.throwIfAborted();
    if (silence.isOver || !(await answersWithoutCors(url, signal))) {
      const what = silence.isOver ? "the server does not answer" : "the server cannot be reached";
      throw new TransferError("unreachable", `${url}: ${what}`, cause);
    }
    // CORS allowed earlier responses of this host, so this is an error response without CORS headers.
    throw new TransferError(
      traffic.hasAnswered ? "server-fault" : "cors-refused",
      `${url}: the host responds, but without Access-Control-Allow-Origin for this page`,
      cause,
    );
  }
}

/**
 * Whether a host of another origin responds at all. Browsers report a refusal by CORS and an
 * unreachable host in the same way. But an opaque request (mode no-cors) succeeds if the host
 * responds.
 */
async function answersWithoutCors(url: string, signal: AbortSignal): Promise<boolean> {
  if (typeof location === "undefined") return false;
  if (new URL(url, location.href).origin === location.origin) return false;
  try {
    await fetch(url, { method: "HEAD", mode: "no-cors", cache: "no-store", signal });
    return true;
  } catch {
    signal.throwIfAborted();
    return false;
  }
}

async function check(response: Response, url: string, options: TransferOptions): Promise<void> {
  const { status } = response;
  if (status === (options.range ? 206 : 200)) return;
  if (options.range && status === 200) throw await whyWhole(response, url, options.range[0]);
  const explained = await explanation(response);
  const kind = faultOfStatus(explained?.status ?? "") ?? faultOfCode(status);
  const words = explained?.message ?? codeInWords(response, status);
  const error = new TransferError(kind, `${url}: the server answers ${status} (${words})`);
  error.isOfStore = status === 500 && explained !== undefined;
  const wait = Number(response.headers.get("Retry-After"));
  if (wait > 0) error.retryAfter = Math.min(wait, 60) * 1000;
  throw error;
}

function codeInWords(response: Response, status: number): string {
  if (status !== 416) return response.statusText || "without an explanation";
  const bytes = contentRange(response)?.total;
  return `the file ends before the requested range${bytes === undefined ? "" : `, at ${bytes} bytes`}`;
}

/** Finds out why a host responded to a Range request with the whole file. */
async function whyWhole(response: Response, url: string, first: number): Promise<StreamError> {
  if (response.headers.get("Content-Length") === "0") {
    return new StreamError("cut-short", `${url}: expected a store, found a file of 0 bytes`);
  }
  // Some hosts respond to every unknown address with the same page.
  if (first === 0) {
    const found = await firstBytes(response, storeMagic.length);
    if (!beginsAsStore(found) && !beginsAsBundle(found)) {
      const type = response.headers.get("Content-Type") ?? "something else";
      return new StreamError("not-a-store", `${url}: expected a store, found ${type}`);
    }
  }
  return new StreamError(
    "no-range",
    `${url}: expected an answer to a Range request (206), found the whole file (200). ` +
      "Check that the host supports HTTP Range requests",
  );
}

/** The server's error message (server/HTTP.md, Errors), if there is one. */
async function explanation(
  response: Response,
): Promise<{ status: string; message: string } | undefined> {
  if (!response.headers.get("Content-Type")?.includes("json")) return undefined;
  try {
    const text = new TextDecoder().decode(await firstBytes(response, longestExplanation));
    const { status, message } = JSON.parse(text) as { status?: unknown; message?: unknown };
    if (typeof status !== "string" || typeof message !== "string") return undefined;
    return { status, message };
  } catch {
    return undefined;
  }
}

/**
 * The first bytes of the body: at least `count`, unless the body is shorter. Does not read the rest.
 */
async function firstBytes(response: Response, count: number): Promise<Uint8Array> {
  const parts: Uint8Array[] = [];
  const reader = response.body?.getReader();
  for (let have = 0; have < count; ) {
    const step = await reader?.read();
    if (!step || step.done) break;
    parts.push(step.value);
    have += step.value.length;
  }
  void reader?.cancel().catch(() => {});
  return joined(parts);
}

/**
 * Parses Content-Range: the first and last byte of the response, and the size of the whole file.
 */
function contentRange(
  response: Response,
): { first: number | undefined; last: number | undefined; total: number | undefined } | undefined {
  const field = response.headers.get("Content-Range") ?? "";
  const match = /^bytes (?:(\d+)-(\d+)|\*)\/(\d+|\*)$/.exec(field);
  if (!match) return undefined;
  const number = (text: string | undefined): number | undefined =>
    text === undefined || text === "*" ? undefined : Number(text);
  return { first: number(match[1]), last: number(match[2]), total: number(match[3]) };
}

/** Checks the response's headers. Returns the size of the body, if it is known. */
function identify(response: Response, url: string, options: TransferOptions): number | undefined {
  const range = contentRange(response);
  const etag = response.headers.get("ETag") ?? undefined;
  options.identify?.({ etag, bytes: range?.total }, response.headers);
  if (!options.range || !range) return undefined;
  const [first, last] = options.range;
  if (range.first !== first || range.last === undefined || range.last > last) {
    throw new TransferError(
      "server-fault",
      `${url}: expected bytes ${first} to ${last}, found ${response.headers.get("Content-Range")}`,
    );
  }
  return range.last - first + 1;
}

/** Calls `arrived`. Its errors are not faults of the connection, so they become `internal`. */
function hand(part: Uint8Array, arrived: (part: Uint8Array) => void): void {
  try {
    arrived(part);
  } catch (error) {
    if (error instanceof StreamError) throw error;
    throw new StreamError("internal", String(error), error);
  }
}

async function read(
  response: Response,
  url: string,
  options: TransferOptions & { wanted: number | undefined },
  traffic: Traffic,
  arrived: (part: Uint8Array) => void,
): Promise<void> {
  const length = response.headers.get("Content-Length");
  const isCoded = response.headers.has("Content-Encoding");
  const announced = length === null || isCoded ? options.wanted : Number(length);
  const most = options.range ? options.range[1] - options.range[0] + 1 : announced;
  let received = 0;
  const reader = response.body?.getReader();
  for (;;) {
    const step = await reader?.read();
    if (!step || step.done) break;
    received += step.value.length;
    traffic.bytesReceived += step.value.length;
    if (most !== undefined && received > most) {
      throw new TransferError(
        "server-fault",
        `${url}: expected ${most} bytes, found more: this is not the requested data`,
      );
    }
    hand(step.value, arrived);
  }
  if (announced !== undefined && received !== announced) {
    throw new TransferError(
      "unreachable",
      `${url}: expected ${announced} bytes, found ${received}: the connection broke`,
    );
  }
}
