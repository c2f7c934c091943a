/**
 * Measures vtk.js on the same links. It fetches the volume as gzip, and runs marching cubes in the
 * page.
 */
import { readFileSync } from "node:fs";
import { basename, dirname, join } from "node:path";
import type { Browser } from "@playwright/test";
import { type PeerSite, servePage } from "../../evidence/peer_visits/serve_page.ts";
import type { Bench } from "../harness/benchmark.ts";
import { type Link, Visitor } from "./visit.ts";

export interface Peer extends PeerSite {
  query: string;
}

/** Serves the peer's page with an NRRD of bytes (detached, gzip). Undefined if it was skipped. */
export async function servePeer(
  bench: Bench,
  header: string,
  page = "vtk_js",
): Promise<Peer | undefined> {
  const text = readFileSync(header, "latin1");
  const field = (name: string): string =>
    new RegExp(`^${name}: *(.*)$`, "m").exec(text)?.[1]?.trim() ?? "";
  const data = join(dirname(header), field("data file"));
  const site = await servePage(bench, page, new Map([[basename(data), readFileSync(data)]]));
  if (!site) return undefined;
  const spacing = field("spacings").split(/\s+/).join(",") || "1,1,1";
  const dims = field("sizes").split(/\s+/).join(",");
  return { ...site, query: `volume=${basename(data)}&dims=${dims}&spacing=${spacing}` };
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
