/** A peer's page on a separate server, with the files that it fetches. */
import { existsSync, readdirSync, readFileSync } from "node:fs";
import { createServer, type Server } from "node:http";
import type { AddressInfo } from "node:net";
import { extname, join } from "node:path";
import { brotliCompressSync } from "node:zlib";
import { build } from "vite";
import type { Bench } from "../../bench/harness/benchmark.ts";

export interface PeerSite {
  url: string;
  server: Server;
}

const types: Record<string, string> = {
  ".html": "text/html",
  ".js": "text/javascript",
  ".json": "application/json",
};

/**
 * Builds the page tests/evidence/peers/PAGE and serves it, with Brotli like Isosplat's page, and
 * the data unchanged. `data`: contents by path. Undefined: skipped.
 */
export async function servePage(
  bench: Bench,
  page: string,
  data: ReadonlyMap<string, Buffer>,
): Promise<PeerSite | undefined> {
  const peers = join(bench.root, "tests/evidence/peers");
  if (!existsSync(join(peers, "node_modules"))) {
    bench.skip(page, "not installed (npm ci --prefix tests/evidence/peers)");
    return undefined;
  }
  const root = join(peers, page);
  const outDir = join(bench.folder, page);
  await build({ root, configFile: false, logLevel: "error", build: { outDir, target: "es2022" } });
  const built = new Map(
    readdirSync(outDir, { recursive: true, withFileTypes: true })
      .filter((entry) => entry.isFile())
      .map(({ parentPath, name }) => {
        const file = join(parentPath, name);
        return [file.slice(outDir.length + 1), brotliCompressSync(readFileSync(file))];
      }),
  );
  const server = createServer((request, response) => {
    const path = new URL(request.url ?? "/", "http://peer").pathname.slice(1) || "index.html";
    const program = built.get(path);
    const content = program ?? data.get(path);
    if (!content) return response.writeHead(404).end();
    response.writeHead(200, {
      "Content-Type": types[extname(path)] ?? "application/octet-stream",
      "Content-Length": content.length,
      "Cache-Control": "max-age=3600",
      ...(program && { "Content-Encoding": "br" }),
    });
    return response.end(content);
  });
  await new Promise<void>((resolve) => server.listen(0, "127.0.0.1", resolve));
  return { url: `http://127.0.0.1:${(server.address() as AddressInfo).port}/`, server };
}
