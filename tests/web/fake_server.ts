/**
 * A server of one store that misbehaves on request: it answers `/store.isosplat` with Range and the
 * routes of server/HTTP.md that streaming uses.
 */
import { createServer, type IncomingMessage, type Server, type ServerResponse } from "node:http";
import type { AddressInfo, Socket } from "node:net";
import type { Chunk, Store } from "../../web/core/index.ts";

/** How one answer goes wrong. */
export type Fault =
  | { kind: "status"; status: number; retryAfter?: number }
  /** Breaks the connection before the answer. */
  | { kind: "reset" }
  /** Breaks it after so many bytes of the body. */
  | { kind: "truncate"; bytes: number }
  /** Flips a bit of the body's byte at this place (negative: from its end). */
  | { kind: "corrupt"; at: number }
  | { kind: "delay"; milliseconds: number }
  /** Sends the body in pieces of this size, a moment apart. */
  | { kind: "drip"; bytes: number };

export interface Asked {
  path: string;
  range?: string;
  /** Bytes of the body that were sent. */
  bytes: number;
}

export class FakeServer {
  /** Every request, in the order they came. */
  readonly asked: Asked[] = [];
  /** Chunks sent, by `level/x.y.z/slab` or by `offset`. */
  readonly chunksSent: string[] = [];
  /** Decides for each request whether it goes wrong. */
  fault: (path: string, number: number) => Fault | undefined = () => undefined;
  /** Answers a Range request with the whole file. */
  ignoresRange = false;
  readonly #file: Uint8Array;
  readonly #store: Store;
  #server: Server | undefined;
  #port = 0;
  readonly #sockets = new Set<Socket>();

  /** `store` has every page of `file`. */
  constructor(file: Uint8Array, store: Store) {
    this.#file = file;
    this.#store = store;
  }

  get url(): string {
    return `http://127.0.0.1:${this.#port}`;
  }

  get contentId(): string {
    return this.#store.info.contentId;
  }

  get bytesSent(): number {
    return this.asked.reduce((bytes, { bytes: sent }) => bytes + sent, 0);
  }

  /** Starts, or comes back on the same port. */
  async start(): Promise<void> {
    const server = createServer((request, response) => void this.#answer(request, response));
    server.on("connection", (socket) => {
      this.#sockets.add(socket);
      socket.on("close", () => this.#sockets.delete(socket));
    });
    await new Promise<void>((resolve, reject) => {
      server.once("error", reject);
      server.listen(this.#port, "127.0.0.1", resolve);
    });
    this.#port = (server.address() as AddressInfo).port;
    this.#server = server;
  }

  async stop(): Promise<void> {
    const server = this.#server;
    this.#server = undefined;
    for (const socket of this.#sockets) socket.destroy();
    await new Promise((resolve) => (server ? server.close(resolve) : resolve(undefined)));
  }

  async #answer(request: IncomingMessage, response: ServerResponse): Promise<void> {
    const url = new URL(request.url ?? "/", this.url);
    const path = decodeURIComponent(url.pathname + url.search);
    const asked: Asked = { path, bytes: 0 };
    if (request.headers.range) asked.range = request.headers.range;
    this.asked.push(asked);
    const fault = this.fault(path, this.asked.length);
    if (fault?.kind === "delay") {
      await new Promise((resolve) => setTimeout(resolve, fault.milliseconds));
    }
    if (fault?.kind === "reset") {
      request.socket.destroy();
      return;
    }
    if (fault?.kind === "status") {
      const headers: Record<string, string> = { "Content-Type": "application/json" };
      if (fault.retryAfter !== undefined) headers["Retry-After"] = String(fault.retryAfter);
      response.writeHead(fault.status, headers);
      response.end(JSON.stringify({ error: { status: "test", message: "so it was asked" } }));
      return;
    }
    const found = this.#find(url, request.headers.range);
    if (!found) {
      response.writeHead(404, { "Content-Type": "application/json" });
      response.end(JSON.stringify({ error: { status: "not_found", message: "no such thing" } }));
      return;
    }
    let body = found.body;
    if (fault?.kind === "corrupt") {
      body = body.slice();
      const at = (fault.at + body.length) % body.length;
      body[at] = (body[at] ?? 0) ^ 4;
    }
    response.writeHead(found.status, { "Content-Length": body.length });
    const piece = fault?.kind === "drip" ? fault.bytes : 65536;
    const end = fault?.kind === "truncate" ? Math.min(fault.bytes, body.length) : body.length;
    for (let at = 0; at < end && !response.destroyed; at += piece) {
      response.write(body.subarray(at, Math.min(at + piece, end)));
      asked.bytes += Math.min(piece, end - at);
      if (fault?.kind === "drip") await new Promise((resolve) => setTimeout(resolve, 1));
    }
    if (end < body.length) setTimeout(() => request.socket.destroy(), 5);
    else response.end();
  }

  #find(url: URL, range: string | undefined): { status: number; body: Uint8Array } | undefined {
    const content = `/v1/volumes/test/${this.contentId}`;
    const { pathname } = url;
    if (pathname === "/v1/volumes/test/opening") return { status: 200, body: this.#opening() };
    if (pathname === "/store.isosplat" || pathname === `${content}/file`) {
      const match = /^bytes=(\d+)-(\d+)$/.exec(range ?? "");
      if (!match || this.ignoresRange) return { status: 200, body: this.#file };
      const from = Number(match[1]);
      const body = this.#file.subarray(from, Number(match[2]) + 1);
      for (const chunk of this.#chunks()) {
        if (chunk.offset >= from && chunk.offset + chunk.bytes <= Number(match[2]) + 1) {
          this.chunksSent.push(name(chunk));
        }
      }
      return { status: 206, body };
    }
    if (pathname === `${content}/head`) return { status: 200, body: this.#file.subarray(0, 65536) };
    if (pathname.startsWith(`${content}/chunks/`)) {
      const chunk = this.#chunk(pathname.slice(`${content}/chunks/`.length));
      return chunk && { status: 200, body: this.#bytes(chunk) };
    }
    if (pathname === `${content}/batch`) {
      const frames: number[] = [];
      for (const place of (url.searchParams.get("chunks") ?? "").split(",")) {
        const chunk = this.#chunk(place);
        if (!chunk) return undefined;
        for (const byte of frame(chunk, this.#bytes(chunk))) frames.push(byte);
      }
      return { status: 200, body: Uint8Array.from(frames) };
    }
    return undefined;
  }

  #allChunks: Chunk[] | undefined;
  #chunks(): Chunk[] {
    const [low, high] = this.#store.info.range;
    this.#allChunks ??= Array.from({ length: this.#store.info.levels }, (_, level) =>
      this.#store.chunksFor(level, low, high),
    ).flat();
    return this.#allChunks;
  }

  #chunk(place: string): Chunk | undefined {
    const chunk = this.#chunks().find((candidate) => name(candidate) === place);
    if (chunk) this.chunksSent.push(place);
    return chunk;
  }

  #opening(): Uint8Array {
    const { offset, bytes } = this.#store.openingRange();
    const head = this.#file.subarray(0, this.#store.coarseRange(Number.MAX_SAFE_INTEGER).offset);
    const rest = this.#file.subarray(offset, offset + bytes);
    const words = Uint32Array.of(head.length, rest.length, offset, 0);
    const id = Buffer.from(this.contentId, "hex");
    return Buffer.concat([new Uint8Array(words.buffer), id, head, rest]);
  }

  #bytes(chunk: Chunk): Uint8Array {
    return this.#file.subarray(chunk.offset, chunk.offset + chunk.bytes);
  }
}

function name(chunk: Chunk): string {
  return `${chunk.level}/${chunk.block.join(".")}/${chunk.slab}`;
}

function frame(chunk: Chunk, bytes: Uint8Array): Uint8Array {
  const result = new Uint8Array(48 + Math.ceil(bytes.length / 16) * 16);
  const words = [
    bytes.length,
    0,
    chunk.level,
    ...chunk.block,
    chunk.slab,
    chunk.cells,
    chunk.slabBegin,
    chunk.slabEnd,
    chunk.checksum,
    0,
  ];
  const view = new DataView(result.buffer);
  for (const [i, word] of words.entries()) view.setUint32(4 * i, word, true);
  result.set(bytes, 48);
  return result;
}
