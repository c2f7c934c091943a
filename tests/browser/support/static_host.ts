import { readFileSync, statSync } from "node:fs";
import { createServer } from "node:http";
import type { AddressInfo } from "node:net";
import { extname, join } from "node:path";

export interface StaticHostOptions {
  /** Folders to look in, in turn. */
  folders: readonly string[];
  /** Answer Range requests with parts; without, with the whole file. */
  range: boolean;
  /** Changes a file's bytes before they are sent. */
  change?: (path: string, bytes: Buffer) => Buffer;
}

export interface StaticHost {
  /** With a slash at the end. */
  url: string;
  stop(): Promise<void>;
}

const types: Record<string, string> = {
  ".html": "text/html",
  ".js": "text/javascript",
  ".css": "text/css",
  ".svg": "image/svg+xml",
  // .wasm is left out, as many static hosts do.
};

/** A host that knows nothing of Isosplat: files, and Range if wanted. */
export async function staticHost(options: StaticHostOptions): Promise<StaticHost> {
  const server = createServer((request, response) => {
    const path = new URL(request.url ?? "/", "http://host").pathname;
    const name = path === "/" ? "index.html" : decodeURIComponent(path.slice(1));
    const file = options.folders.map((f) => join(f, name)).find((f) => isFile(f));
    response.setHeader("Access-Control-Allow-Origin", "*");
    response.setHeader("Access-Control-Expose-Headers", "Content-Range, Content-Length, ETag");
    if (!file || request.method === "OPTIONS") {
      response.setHeader("Access-Control-Allow-Headers", "Range");
      response.writeHead(file ? 204 : 404).end();
      return;
    }
    let bytes: Buffer = readFileSync(file);
    if (options.change) bytes = options.change(name, bytes);
    response.setHeader("Content-Type", types[extname(file)] ?? "application/octet-stream");
    const range = /^bytes=(\d+)-(\d*)$/.exec(request.headers.range ?? "");
    if (options.range && range) {
      const first = Number(range[1]);
      const last = Math.min(range[2] ? Number(range[2]) : bytes.length - 1, bytes.length - 1);
      response.setHeader("Content-Range", `bytes ${first}-${last}/${bytes.length}`);
      response.writeHead(206).end(bytes.subarray(first, last + 1));
    } else {
      response.writeHead(200).end(bytes);
    }
  });
  await new Promise<void>((resolve) => server.listen(0, "127.0.0.1", resolve));
  return {
    url: `http://127.0.0.1:${(server.address() as AddressInfo).port}/`,
    stop: () =>
      new Promise((resolve) => {
        server.closeAllConnections();
        server.close(() => resolve());
      }),
  };
}

function isFile(path: string): boolean {
  try {
    return statSync(path).isFile();
  } catch {
    return false;
  }
}
