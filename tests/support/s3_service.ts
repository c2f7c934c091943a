/**
 * An S3 service: s3rver, which stores buckets in a folder, behind a gate that verifies signatures
 * and checksums of bodies, as AWS does and s3rver does not.
 */
import {
  createServer,
  type IncomingMessage,
  request as makeRequest,
  type Server,
  type ServerResponse,
} from "node:http";
import type { AddressInfo } from "node:net";
import S3rver from "s3rver";
import { type Account, signatureError } from "./aws_signature.ts";

export const account: Account = {
  accessKey: "S3RVER", // the only one that s3rver knows
  secretKey: "secret/with+signs=",
  region: "eu-test-1",
};

export class S3Service {
  /** Whose requests pass. */
  account: Account = account;
  /** Whether requests without a signature may read. */
  isPublic = false;
  /** How far the service's clock is ahead (ms). */
  clockAhead = 0;
  /** The code of each refused request. */
  readonly refused: string[] = [];
  readonly #storage: S3rver;
  readonly #gate: Server;
  #storagePort = 0;

  constructor(folder: string, bucket: string) {
    this.#storage = new S3rver({
      address: "127.0.0.1",
      port: 0,
      silent: true,
      directory: folder,
      configureBuckets: [{ name: bucket, configs: [] }],
    });
    this.#gate = createServer((request, response) => {
      // A client may leave before its request is whole, for example after its own time limit.
      void this.#handle(request, response).catch(() => response.destroy());
    });
  }

  /** Without a slash at the end. */
  get url(): string {
    return `http://127.0.0.1:${(this.#gate.address() as AddressInfo).port}`;
  }

  async start(): Promise<void> {
    this.#storagePort = (await this.#storage.run()).port;
    await new Promise<void>((listening) => this.#gate.listen(0, "127.0.0.1", listening));
  }

  /** Writes an object, past the gate. `path`: "BUCKET/KEY", percent-encoded. */
  async put(path: string, bytes: Uint8Array): Promise<void> {
    const url = `http://127.0.0.1:${this.#storagePort}/${path}`;
    const answer = await fetch(url, { method: "PUT", body: new Uint8Array(bytes) });
    if (!answer.ok) throw new Error(`${path}: expected status 200, found ${answer.status}`);
  }

  /** The bytes of an object, past the gate; undefined: there is none. */
  async get(path: string): Promise<{ bytes: Buffer; headers: Headers } | undefined> {
    const answer = await fetch(`http://127.0.0.1:${this.#storagePort}/${path}`);
    if (!answer.ok) return undefined;
    return { bytes: Buffer.from(await answer.arrayBuffer()), headers: answer.headers };
  }

  async stop(): Promise<void> {
    this.#gate.closeAllConnections();
    this.#gate.close();
    await this.#storage.close();
  }

  async #handle(request: IncomingMessage, response: ServerResponse): Promise<void> {
    const body = await whole(request);
    const { method = "GET", url: target = "/", headers } = request;
    const code = this.#refusal(method, target, headers, body);
    if (code) {
      this.refused.push(code);
      const xml = `<Error><Code>${code}</Code><Message>refused by the gate</Message></Error>`;
      response.writeHead(code === "XAmzContentSHA256Mismatch" ? 400 : 403).end(xml);
      return;
    }
    const port = this.#storagePort;
    const path = { hostname: "127.0.0.1", port, method, path: target, headers };
    const upstream = makeRequest(path, (reply) => {
      response.writeHead(reply.statusCode ?? 500, reply.headers);
      reply.pipe(response);
    });
    upstream.on("error", () => response.destroy());
    upstream.end(body);
  }

  #refusal(
    method: string,
    target: string,
    headers: IncomingMessage["headers"],
    body: Buffer,
  ): string | undefined {
    if (this.isPublic && !headers.authorization && method === "GET") return undefined;
    const now = Date.now() + this.clockAhead;
    return signatureError({ method, target, headers, body }, this.account, now);
  }
}

async function whole(request: IncomingMessage): Promise<Buffer> {
  const pieces: Buffer[] = [];
  for await (const piece of request) pieces.push(piece as Buffer);
  return Buffer.concat(pieces);
}
