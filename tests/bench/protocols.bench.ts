// Compares HTTP/1.1, 2 and 3 from Caddy, in front of the server, to Chromium over a link with a
// round trip of 40 ms. Measures the time until the first response, and until all chunks of an
// isovalue, each with a separate URL.
import { once } from "node:events";
import { join } from "node:path";
import { chromium } from "@playwright/test";
import { launchOptions } from "../browser/support/chromium.ts";
import { hasCaddy, startCaddy } from "../support/caddy.ts";
import { freePort } from "../support/nginx.ts";
import type { Bench, Benchmark } from "./harness/benchmark.ts";
import { openDelayedLink } from "./harness/delayed_link.ts";

const roundTripMs = 40;

/** The paths of the chunks of a level that an isovalue needs, from the frames of one response. */
async function chunkPaths(server: string, name: string, isovalue: number): Promise<string[]> {
  const volume = (await (await fetch(`${server}/v1/volumes/${name}`)).json()) as {
    contentId: string;
  };
  const content = `/v1/volumes/${name}/${volume.contentId}`;
  const answer = await fetch(`${server}${content}/chunks?isovalue=${isovalue}&level=0`);
  const frames = Buffer.from(await answer.arrayBuffer());
  const paths: string[] = [];
  for (let at = 0; at < frames.length; ) {
    const field = (i: number) => frames.readUInt32LE(at + 4 * i);
    paths.push(`${content}/chunks/${field(2)}/${field(3)}.${field(4)}.${field(5)}/${field(6)}`);
    at += 48 + Math.ceil(field(0) / 16) * 16;
  }
  return paths;
}

interface Visit {
  firstMs: number;
  chunksMs: number;
}

async function visit(args: string[], origin: string, paths: string[], expected: string) {
  const browser = await chromium.launch({
    ...launchOptions,
    args: [...(launchOptions.args ?? []), ...args],
  });
  try {
    const page = await browser.newPage();
    await page.goto(`${origin}/healthz`);
    const { protocol, ...times } = await page.evaluate(async (urls) => {
      const [entry] = performance.getEntriesByType("navigation") as PerformanceResourceTiming[];
      if (!entry) throw new Error("no timing");
      const begin = performance.now();
      await Promise.all(
        urls.map(async (url) => {
          const response = await fetch(url, { cache: "no-store" });
          if (!response.ok) throw new Error(`${url}: ${response.status}`);
          await response.arrayBuffer();
        }),
      );
      return {
        protocol: entry.nextHopProtocol,
        firstMs: entry.responseEnd - entry.fetchStart,
        chunksMs: performance.now() - begin,
      };
    }, paths);
    if (protocol !== expected) throw new Error(`expected ${expected}, found ${protocol}`);
    return times satisfies Visit;
  } finally {
    await browser.close();
  }
}

async function run(bench: Bench): Promise<void> {
  if (!hasCaddy) {
    bench.skip("Caddy", "not installed (.ci/install-packages --for test)");
    return;
  }
  await bench.command(bench.isosplat, ["demo", bench.folder, "--only", "mandelbulb"]);
  const store = join(bench.folder, "mandelbulb.isosplat");
  await bench.command(bench.isosplat, [
    "build",
    join(bench.folder, "mandelbulb.nrrd"),
    "-o",
    store,
  ]);
  const port = await freePort();
  // biome-ignore format: options with their values
  const server = bench.start(bench.isosplat, [
    "serve", store, "--port", String(port), "--allow-host", "volumes.example",
    "--connections-per-address", "0",
  ]);
  if (server.stdout) await once(server.stdout, "data");
  const paths = await chunkPaths(`http://127.0.0.1:${port}`, "mandelbulb", 100);
  const caddy = await startCaddy(bench.folder, port);
  const link = await openDelayedLink(caddy.port, roundTripMs);
  try {
    const host = `volumes.example:${link.port}`;
    const visits = { http1: [] as Visit[], http2: [] as Visit[], http3: [] as Visit[] };
    const measure = async (list: Visit[], flags: string[], protocol: string) => {
      const seen = await visit(
        [...caddy.chromiumArguments, ...flags],
        `https://${host}`,
        paths,
        protocol,
      );
      list.push(seen);
      return seen.chunksMs;
    };
    await bench.interleave({
      http1: () => measure(visits.http1, ["--disable-http2", "--disable-quic"], "http/1.1"),
      http2: () => measure(visits.http2, ["--disable-quic"], "h2"),
      http3: () => measure(visits.http3, [`--origin-to-force-quic-on=${host}`], "h3"),
    });
    const base = visits.http1.slice(1);
    for (const [name, list] of [
      ["HTTP/1.1", visits.http1],
      ["HTTP/2", visits.http2],
      ["HTTP/3", visits.http3],
    ] as const) {
      const counted = list.slice(1);
      const chunks = `${paths.length} chunks`;
      const ratios = counted.map(({ chunksMs }, i) => chunksMs / (base[i]?.chunksMs ?? Number.NaN));
      // biome-ignore format: one figure a line
      bench.report(name, "first response", "ms", counted.map(({ firstMs }) => firstMs));
      // biome-ignore format: one figure a line
      bench.report(name, chunks, "ms", counted.map(({ chunksMs }) => chunksMs));
      if (name !== "HTTP/1.1") bench.report(name, `${chunks}, ratio to HTTP/1.1`, "", ratios);
    }
  } finally {
    link.close();
    await caddy.stop();
  }
}

export default {
  title: "HTTP/1.1, 2 and 3 over a link with a round trip of 40 ms",
  run,
} satisfies Benchmark;
