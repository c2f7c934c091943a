/** `fetch` over HTTP/2 for the page's client in Node, which notes each request. */
import { once } from "node:events";
import { type ClientHttp2Session, constants, type IncomingHttpHeaders } from "node:http2";
import type { RecordedRequest } from "./requests.ts";

/** The header field in which a session names its visitor. It is not sent. */
export const visitorField = "X-Visitor";

/** The requests of one visitor, over a separate connection. */
export class VisitRecorder {
  readonly requests: RecordedRequest[] = [];
  readonly #connection: ClientHttp2Session;
  readonly #begin = performance.now();
  readonly #isMultiplexed: boolean;

  /** `isMultiplexed`: whether the client is told that this is HTTP/2. */
  constructor(connection: ClientHttp2Session, isMultiplexed: boolean) {
    this.#connection = connection;
    this.#isMultiplexed = isMultiplexed;
    connection.on("error", () => {});
  }

  /** Milliseconds since the visit began. */
  get now(): number {
    return performance.now() - this.#begin;
  }

  async fetch(url: URL, init: RequestInit): Promise<Response> {
    const path = url.pathname + url.search;
    const range = new Headers(init.headers).get("Range");
    const noted: RecordedRequest = { at: this.now, path, ...(range && { range }), bytes: 0 };
    this.requests.push(noted);
    const stream = this.#connection.request({ ":path": path, ...(range && { range }) });
    const giveUp = () => {
      if (stream.closed) return;
      noted.cancelledAfter = this.now - noted.at;
      stream.close(constants.NGHTTP2_CANCEL);
    };
    stream.on("error", () => {});
    const signal = init.signal ?? undefined;
    signal?.addEventListener("abort", giveUp, { once: true });
    const [headers] = (await once(stream, "response", { signal })) as [IncomingHttpHeaders];
    if (path.endsWith("/bootstrap") && this.#isMultiplexed) markAsHttp2(url.href);
    const body = new ReadableStream<Uint8Array>({
      start(controller) {
        stream.on("data", (data: Buffer) => {
          noted.bytes += data.length;
          if (!signal?.aborted) controller.enqueue(new Uint8Array(data));
        });
        stream.on("end", () => {
          if (!signal?.aborted) controller.close();
        });
        stream.on("close", () => signal?.removeEventListener("abort", giveUp));
        signal?.addEventListener("abort", () => controller.error(signal.reason), { once: true });
      },
      cancel: giveUp,
    });
    const fields = Object.entries(headers).filter(([name]) => !name.startsWith(":"));
    return new Response(body, {
      status: Number(headers[":status"]),
      headers: fields.map(([name, value]) => [name, String(value)] as [string, string]),
    });
  }
}

/** The client reads its protocol from the timing of its first request, as in a browser. */
function markAsHttp2(url: string): void {
  const none = { finalNetworkRequestStartTime: 0, finalNetworkResponseStartTime: 0, endTime: 0 };
  const timing = {
    ...{ startTime: 0, redirectStartTime: 0, redirectEndTime: 0, postRedirectStartTime: 0 },
    ...{ finalServiceWorkerStartTime: 0, encodedBodySize: 0, decodedBodySize: 0, ...none },
    finalConnectionTimingInfo: { ALPNNegotiatedProtocol: "h2" },
  };
  // Node has this function for libraries that bring their own fetch.
  const { performance } = globalThis as unknown as {
    performance: { markResourceTiming(...values: unknown[]): void };
  };
  performance.markResourceTiming(timing, url, "fetch", globalThis, "");
}

/**
 * Replaces `fetch` by that of the visitors, and imitates the parts of a page from which the client
 * reads its protocol. The returned function undoes both.
 */
export function installFetch(visitors: ReadonlyMap<string, VisitRecorder>): () => void {
  const before = globalThis.fetch;
  globalThis.fetch = async (input, init = {}) => {
    const headers = new Headers(init.headers);
    const visitor = visitors.get(headers.get(visitorField) ?? "");
    if (!visitor) throw new Error(`${String(input)}: expected the request of a visitor`);
    return visitor.fetch(new URL(String(input)), init);
  };
  (globalThis as { window?: unknown }).window = globalThis;
  return () => {
    globalThis.fetch = before;
    delete (globalThis as { window?: unknown }).window;
    performance.clearResourceTimings();
  };
}
