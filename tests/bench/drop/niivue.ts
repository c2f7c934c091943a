/** NiiVue's page, with a file dropped on it. */
import { existsSync } from "node:fs";
import { join } from "node:path";
import { build, type PreviewServer, preview } from "vite";
import type { Bench } from "../harness/benchmark.ts";

/** Builds the page and serves it; undefined: skipped. */
export async function serveNiiVue(
  bench: Bench,
): Promise<{ url: string; server: PreviewServer } | undefined> {
  const peers = join(bench.root, "tests/evidence/peers");
  if (!existsSync(join(peers, "node_modules"))) {
    bench.skip("NiiVue", "not installed (npm ci --prefix tests/evidence/peers)");
    return undefined;
  }
  const shared = {
    root: join(peers, "drop"),
    configFile: false,
    logLevel: "error",
    build: { outDir: join(bench.folder, "niivue"), target: "es2022" },
  } as const;
  await build(shared);
  const server = await preview({ ...shared, preview: { port: 0, host: "127.0.0.1" } });
  const url = server.resolvedUrls?.local[0];
  if (!url) throw new Error("NiiVue's page has no address");
  return { url, server };
}
