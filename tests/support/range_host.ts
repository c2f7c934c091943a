/** A static host that answers Range requests from pages of any origin, and records them. */
import { createServer } from "node:http";
import type { AddressInfo } from "node:net";

export interface RangeHost {
  /** Without a slash at the end. */
  origin: string;
  /** Each request: its path and its range. */
  asked: string[];
  stop(): void;
}

/** `read`: the file at a path, which begins with "/"; undefined: there is none. */
export async function rangeHost(
  read: (path: string) => Uint8Array | undefined,
): Promise<RangeHost> {
  const asked: string[] = [];
  const server = createServer((request, response) => {
    const path = new URL(request.url ?? "", "http://host").pathname;
    asked.push(`${path} ${request.headers.range ?? ""}`.trim());
    response.setHeader("Access-Control-Allow-Origin", "*");
    response.setHeader("Access-Control-Allow-Headers", "Range");
    response.setHeader("Access-Control-Expose-Headers", "Content-Range");
    if (request.method === "OPTIONS") return response.end();
    const file = read(path);
    if (!file) return response.writeHead(404).end();
    const [, first, last] = /^bytes=(\d+)-(\d+)$/.exec(request.headers.range ?? "") ?? [];
    if (first === undefined) return response.end(file);
    const end = Math.min(Number(last) + 1, file.length);
    response.writeHead(206, { "Content-Range": `bytes ${first}-${end - 1}/${file.length}` });
    response.end(file.subarray(Number(first), end));
  });
  await new Promise<void>((listening) => server.listen(0, "127.0.0.1", listening));
  const origin = `http://127.0.0.1:${(server.address() as AddressInfo).port}`;
  return { origin, asked, stop: () => server.close() };
}
