/** Stores and the real server for the streaming benchmark. */
import { once } from "node:events";
import { existsSync } from "node:fs";
import { join } from "node:path";
import type { Bench } from "../harness/benchmark.ts";

/** Builds a volume's store in the benchmark's folder. */
export async function buildStore(bench: Bench, volume: string, name: string): Promise<string> {
  const store = join(bench.folder, `${name}.isosplat`);
  bench.say(`building ${name}`);
  await bench.command(bench.isosplat, ["build", volume, "-o", store]);
  return store;
}

/** Serves stores with the built page, on a free port, until the benchmark ends. */
export async function serve(bench: Bench, stores: string[]): Promise<string> {
  const page = join(bench.root, "build/page");
  if (!existsSync(join(page, "index.html"))) throw new Error("no page: npm run build -- page");
  const server = bench.start(bench.isosplat, [
    "serve",
    ...stores,
    "--port",
    "0",
    "--web-root",
    page,
  ]);
  let text = "";
  const stream = server.stdout;
  if (!stream) throw new Error("the server has no output");
  for (;;) {
    const [data] = (await once(stream, "data")) as [Buffer];
    text += data.toString();
    const [url] = /http:\/\/[^\s/]+\//.exec(text) ?? [];
    if (url) return url;
  }
}
