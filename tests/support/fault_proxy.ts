/**
 * A proxy in front of a real server that injects faults on request. It handles HTTP only,
 * independent of the API; undisturbed responses pass unchanged.
 */
import {
  createServer,
  type IncomingMessage,
  request as makeRequest,
  type Server,
  type ServerResponse,
} from "node:http";
import type { AddressInfo, Socket } from "node:net";
import { Transform } from "node:stream";

/** The fault of one response. */
export type Fault =
  /** Sends this status instead of the server's response, like a gateway whose server has failed. */
  | {
      kind: "status";
      status: number;
      retryAfter?: number;
      body?: string;
      headers?: Record<string, string>;
    }
  /** Requests another path from the server and passes its response on. */
  | { kind: "elsewhere"; path: string }
  /** Closes the connection before the response. */
  | { kind: "reset" }
  /** Never responds. */
  | { kind: "silence" }
  /** Closes the connection after this many bytes of the body. */
  | { kind: "truncate"; bytes: number }
  /** Flips a bit of the body's byte at this offset (negative: from its end). */
  | { kind: "corrupt"; at: number }
  /** Flips a bit of the request's body, unless it is empty. */
  | { kind: "corrupt-request" }
  | { kind: "delay"; milliseconds: number }
  /** Removes response header fields whose lower-case names match. */
  | { kind: "without"; field: RegExp }
  /** Removes the Range header, so that the server sends the whole file. */
  | { kind: "whole" }
  /** Sends the body in pieces of this size, with pauses. */
  | { kind: "drip"; bytes: number };

export interface ProxiedRequest {
  method: string;
  path: string;
  range?: string;
  /** Status of the response; 0 while there is none. */
  status: number;
  /** Bytes of the body that were sent. */
  bytes: number;
  /** Time of the request (ms). */
  at: number;
}

export class FaultProxy {
  /** How many connections were opened. */
  connections = 0;
  /** Every request, in order of arrival. */
  readonly requests: ProxiedRequest[] = [];
  /** The server's address, without a slash at the end. */
  target: string;
  /** Selects the fault of each request, if any. */
  fault: (path: string, number: number, method: string) => Fault | undefined = () => undefined;
  /** Passes the client's Host field on, for servers that verify signatures of it. */
  keepsHost = false;
  #server: Server | undefined;
  #port = 0;
  readonly #sockets = new Set<Socket>();

  constructor(target: string) {
    this.target = target.replace(/\/$/, "");
  }

  /** Without a slash at the end. */
  get url(): string {
    return `http://127.0.0.1:${this.#port}`;
  }

  get bytesSent(): number {
    return this.requests.reduce((bytes, { bytes: sent }) => bytes + sent, 0);
  }

  /** Starts listening. After `stop`, it uses the same port again. */
  async start(): Promise<void> {
    const server = createServer((request, response) => void this.#handle(request, response));
    server.on("connection", (socket) => {
      this.connections += 1;
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

  /** Stops listening and closes all connections. */
  async stop(): Promise<void> {
    const server = this.#server;
    this.#server = undefined;
    for (const socket of this.#sockets) socket.destroy();
    await new Promise((resolve) => (server ? server.close(resolve) : resolve(undefined)));
  }

  async #handle(request: IncomingMessage, response: ServerResponse): Promise<void> {
    const path = request.url ?? "/";
    const method = request.method ?? "GET";
    const record: ProxiedRequest = { method, path, status: 0, bytes: 0, at: Date.now() };
    if (request.headers.range) record.range = request.headers.range;
    this.requests.push(record);
    const fault = this.fault(decodeURIComponent(path), this.requests.length, method);
    if (fault?.kind === "silence") return;
    if (fault?.kind === "delay") await pause(fault.milliseconds);
    if (fault?.kind === "reset") {
      request.socket.destroy();
      return;
    }
    if (fault?.kind === "status") {
      record.status = fault.status;
      const headers: Record<string, string> = { "Content-Type": "text/html", ...fault.headers };
      headers["Access-Control-Allow-Origin"] = "*";
      if (fault.retryAfter !== undefined) headers["Retry-After"] = String(fault.retryAfter);
      response.writeHead(fault.status, headers).end(fault.body ?? `<h1>${fault.status}</h1>`);
      return;
    }
    const { hostname, port } = new URL(this.target);
    const headers = { ...request.headers };
    if (!this.keepsHost) headers.host = `${hostname}:${port}`;
    if (fault?.kind === "whole") delete headers.range;
    const upstream = makeRequest({
      hostname,
      port,
      method,
      path: fault?.kind === "elsewhere" ? fault.path : path,
      headers,
    });
    response.on("close", () => upstream.destroy());
    upstream.on("error", () => request.socket.destroy());
    upstream.on("response", (reply) => {
      record.status = reply.statusCode ?? 0;
      void this.#pass(reply, response, record, fault);
    });
    if (fault?.kind === "corrupt-request") request.pipe(flipBit()).pipe(upstream);
    else request.pipe(upstream);
  }

  async #pass(
    reply: IncomingMessage,
    response: ServerResponse,
    record: ProxiedRequest,
    fault: Fault | undefined,
  ): Promise<void> {
    const headers = { ...reply.headers };
    if (fault?.kind === "without") {
      for (const field of Object.keys(headers)) if (fault.field.test(field)) delete headers[field];
    }
    response.writeHead(record.status, headers);
    const send = (bytes: Uint8Array): void => {
      record.bytes += bytes.length;
      response.write(bytes);
    };
    try {
      if (fault?.kind === "truncate" || fault?.kind === "corrupt" || fault?.kind === "drip") {
        await this.#disturb(await whole(reply), response, fault, send);
      } else {
        for await (const piece of reply) send(piece as Uint8Array);
        response.end();
      }
    } catch {
      // The server closed the connection, so the proxy does too, after the bytes that it received.
      setTimeout(() => response.destroy(), 5);
    }
  }

  async #disturb(
    body: Buffer,
    response: ServerResponse,
    fault: Fault & { kind: "truncate" | "corrupt" | "drip" },
    send: (bytes: Uint8Array) => void,
  ): Promise<void> {
    if (fault.kind === "corrupt" && body.length > 0) {
      const at = (((fault.at % body.length) + body.length) % body.length) | 0;
      body[at] = (body[at] ?? 0) ^ 4;
    }
    const end = fault.kind === "truncate" ? Math.min(fault.bytes, body.length) : body.length;
    const piece = fault.kind === "drip" ? fault.bytes : Math.max(1, end);
    for (let at = 0; at < end && !response.destroyed; at += piece) {
      send(body.subarray(at, Math.min(at + piece, end)));
      if (fault.kind === "drip") await pause(1);
    }
    if (end < body.length) setTimeout(() => response.destroy(), 5);
    else response.end();
  }
}

/** Flips a bit of the first byte. */
function flipBit(): Transform {
  let isFirst = true;
  return new Transform({
    transform(piece: Buffer, _encoding, done) {
      if (isFirst) piece[0] = (piece[0] ?? 0) ^ 4;
      isFirst = false;
      done(null, piece);
    },
  });
}

async function whole(reply: IncomingMessage): Promise<Buffer> {
  const pieces: Buffer[] = [];
  for await (const piece of reply) pieces.push(piece as Buffer);
  return Buffer.concat(pieces);
}

function pause(milliseconds: number): Promise<void> {
  return new Promise((resolve) => setTimeout(resolve, milliseconds));
}

/** Byte ranges of the file, or chunk names, that were fetched completely more than once. */
export function fetchedTwice(requests: readonly ProxiedRequest[]): string[] {
  const seen = new Set<string>();
  const twice: string[] = [];
  const note = (name: string): void => {
    if (seen.has(name)) twice.push(name);
    seen.add(name);
  };
  const ranges: [number, number][] = [];
  for (const { path, range } of requests) {
    const text = decodeURIComponent(path);
    const single = /\/chunks\/(\d+\/[\d.]+\/\d+)$/.exec(text)?.[1];
    const batch = /batch\?chunks=(.*)$/.exec(text)?.[1]?.split(",") ?? [];
    for (const name of single ? [single] : batch) note(name);
    const bytes = /^bytes=(\d+)-(\d+)$/.exec(range ?? "");
    // Does not count the first request for the header, whose length is a guess.
    if (bytes && bytes[1] !== "0") ranges.push([Number(bytes[1]), Number(bytes[2])]);
  }
  ranges.sort(([a], [b]) => a - b);
  ranges.forEach(([from], i) => {
    const [, end = -1] = ranges[i - 1] ?? [];
    if (from <= end) twice.push(`bytes ${from} to ${end}`);
  });
  return twice;
}
