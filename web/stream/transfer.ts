import { StreamError } from "./types.ts";

/** What has been asked for and received, by one source. */
export class Traffic {
  requests = 0;
  bytesReceived = 0;
}

export interface TransferOptions {
  /** First and last byte of the resource to ask for. */
  range?: readonly [first: number, last: number];
  /** Past every cache: what the caches hold has turned out wrong. */
  fresh?: boolean;
}

/** A failed request's StreamError with how long the server asks to wait, in ms. */
export class TransferError extends StreamError {
  retryAfter = 0;
}

/**
 * Makes one request and hands on the answer's body as it arrives; `expected` (of a range or a
 * Content-Length) is met exactly, or this rejects. Counts into `traffic`. Rejects with a StreamError
 * or the signal's reason.
 */
export async function transfer(
  url: string,
  options: TransferOptions,
  traffic: Traffic,
  signal: AbortSignal,
  arrived: (part: Uint8Array) => void,
): Promise<void> {
  signal.throwIfAborted();
  ++traffic.requests;
  const headers: Record<string, string> = {};
  if (options.range) headers.Range = `bytes=${options.range[0]}-${options.range[1]}`;
  let response: Response;
  try {
    response = await fetch(url, { headers, signal, cache: options.fresh ? "reload" : "default" });
  } catch (cause) {
    signal.throwIfAborted();
    throw new TransferError("unreachable", `${url}: the server cannot be reached`, true, cause);
  }
  try {
    await check(response, url, options);
    await read(response, url, options, traffic, arrived);
  } catch (cause) {
    // Nobody reads on: let the connection go.
    void response.body?.cancel().catch(() => {});
    signal.throwIfAborted();
    if (cause instanceof StreamError) throw cause;
    throw new TransferError("unreachable", `${url}: the connection broke`, true, cause);
  }
}

/** As `transfer`, into one array. */
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

async function check(response: Response, url: string, options: TransferOptions): Promise<void> {
  const { status } = response;
  if (status === (options.range ? 206 : 200)) return;
  if (options.range && status === 200) {
    throw new StreamError(
      "range-unsupported",
      `${url}: expected an answer to a Range request (206), found the whole file (200). ` +
        "Check that the host supports HTTP Range requests",
    );
  }
  if (status === 408 || status === 429 || status >= 500) {
    const error = new TransferError("unreachable", `${url}: the server answers ${status}`, true);
    const wait = Number(response.headers.get("Retry-After"));
    if (wait > 0) error.retryAfter = Math.min(wait, 60) * 1000;
    throw error;
  }
  const said = await explanation(response);
  throw new StreamError(
    "not-found",
    `${url}: the server answers ${status}${said}. The volume may have been moved or replaced: ` +
      "reload the page",
  );
}

/** The server's own words (server/HTTP.md: error.message), if it has any. */
async function explanation(response: Response): Promise<string> {
  if (!response.headers.get("Content-Type")?.includes("json")) return "";
  try {
    const answer = (await response.json()) as { error?: { message?: unknown } };
    return typeof answer.error?.message === "string" ? ` (${answer.error.message})` : "";
  } catch {
    return "";
  }
}

async function read(
  response: Response,
  url: string,
  options: TransferOptions,
  traffic: Traffic,
  arrived: (part: Uint8Array) => void,
): Promise<void> {
  const length = response.headers.get("Content-Length");
  const isCoded = response.headers.has("Content-Encoding");
  const announced = length === null || isCoded ? undefined : Number(length);
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
        "unreachable",
        `${url}: expected ${most} bytes, found more: the answer is not the one asked for`,
        true,
      );
    }
    arrived(step.value);
  }
  if (announced !== undefined && received !== announced) {
    throw new TransferError(
      "unreachable",
      `${url}: expected ${announced} bytes, found ${received}: the connection broke`,
      true,
    );
  }
}
