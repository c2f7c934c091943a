/** vtk.js on the same links: the volume as gzip, marching cubes in the page. */
import { existsSync, readFileSync } from "node:fs";
import { createServer, type Server } from "node:http";
import type { AddressInfo } from "node:net";
import { basename, dirname, extname, join } from "node:path";
import type { Browser } from "@playwright/test";
import { build } from "vite";
import type { Bench } from "../harness/benchmark.ts";
import { type Link, Visitor } from "./visit.ts";

export interface Peer {
  url: string;
  query: string;
  server: Server;
}

/** Builds the peer's page and serves it with an NRRD of bytes (detached, gzip); undefined: skipped. */
export async function servePeer(bench: Bench, header: string): Promise<Peer | undefined> {
  if (!existsSync(join(bench.root, "tests/bench/peers/node_modules"))) {
    bench.skip("vtk.js", "not installed (npm ci --prefix tests/bench/peers)");
    return undefined;
  }
  const root = join(bench.root, "tests/bench/peers/vtk_js");
  const outDir = join(bench.folder, "vtk_js");
  await build({ root, configFile: false, logLevel: "error", build: { outDir, target: "es2022" } });
  const text = readFileSync(header, "latin1");
  const field = (name: string): string =>
    new RegExp(`^${name}: *(.*)$`, "m").exec(text)?.[1]?.trim() ?? "";
  const data = join(dirname(header), field("data file"));
  const types: Record<string, string> = { ".html": "text/html", ".js": "text/javascript" };
  const server = createServer((request, response) => {
    const path = new URL(request.url ?? "/", "http://peer").pathname;
    const name = path === "/" ? "index.html" : path.slice(1);
    const file = name === basename(data) ? data : join(outDir, name);
    if (!existsSync(file)) return response.writeHead(404).end();
    response.writeHead(200, {
      "Content-Type": types[extname(file)] ?? "application/octet-stream",
      "Cache-Control": "max-age=3600",
    });
    return response.end(readFileSync(file));
  });
  await new Promise<void>((resolve) => server.listen(0, "127.0.0.1", resolve));
  const url = `http://127.0.0.1:${(server.address() as AddressInfo).port}/`;
  const spacing = field("spacings").split(/\s+/).join(",") || "1,1,1";
  const dims = field("sizes").split(/\s+/).join(",");
  return { url, query: `volume=${basename(data)}&dims=${dims}&spacing=${spacing}`, server };
}

export async function measureVtk(
  bench: Bench,
  browser: Browser,
  peer: Peer,
  link: Link,
  runs: number,
): Promise<void> {
  const first: number[] = [];
  const change: number[] = [];
  let megabytes = 0;
  for (let run = 0; run < runs; ++run) {
    const visitor = await Visitor.arrive(browser, link);
    try {
      const page = `${peer.url}?${peer.query}&isovalue=60.5&next=61.5`;
      await visitor.page.goto(page);
      first.push((await visitor.mark("vtk:image")).shown / 1000);
      const changed = await visitor.mark("vtk:changed");
      change.push((changed.shown - (await visitor.mark("vtk:change")).at) / 1000);
      megabytes = (await visitor.bytesOf(".raw.gz")) / 1e6;
    } finally {
      await visitor.leave();
    }
  }
  const what = `engine 60.5, ${link.name}, vtk.js`;
  bench.report(what, "first image, nothing cached", "s", first);
  bench.report(what, "volume over the wire", "MB", megabytes);
  bench.report(what, "new isovalue", "s", change);
}
