// The server: its rates compared with nginx, many and slow clients, many stores, and a mixed load.
import { linkSync, mkdirSync } from "node:fs";
import { join } from "node:path";
import type { Bench, Benchmark } from "./harness/benchmark.ts";
import { type Chunk, chunksOf, contentPath, nearest } from "./server/chunks.ts";
import { Crowd, idle, slowReader, slowWriter } from "./server/crowd.ts";
import {
  get,
  type Host,
  processorSeconds,
  residentMegabytes,
  serveFiles,
  serveStores,
  untilItAnswers,
} from "./server/hosts.ts";
import { mixedLoad } from "./server/mixed_load.ts";
import { type Load, load } from "./server/wrk.ts";

const isovalue = 1000.5;
const pause = (ms: number) => new Promise<void>((resolve) => setTimeout(resolve, ms));

/** Measures the rates of our server and of nginx in turn, and the processor time of a request. */
async function compare(
  bench: Bench,
  what: string,
  { atLeast, atMostCost }: { atLeast?: number; atMostCost?: number },
  sides: { isosplat: [Host, string]; nginx: [Host, string] },
  options?: { connections: number },
): Promise<void> {
  bench.say(what);
  const loads = { isosplat: [] as Load[], nginx: [] as Load[] };
  const costs = { isosplat: [] as number[], nginx: [] as number[] };
  const measure = async (side: "isosplat" | "nginx") => {
    const [host, url] = sides[side];
    const before = processorSeconds(host.pid);
    const seconds = 3;
    const found = await load(bench, url, { ...options, seconds });
    loads[side].push(found);
    const requests = found.requestsPerSecond * seconds;
    costs[side].push(((processorSeconds(host.pid) - before) / requests) * 1e6);
    return options ? found.bytesPerSecond : found.requestsPerSecond;
  };
  const rates = await bench.interleave(
    { isosplat: () => measure("isosplat"), nginx: () => measure("nginx") },
    Math.min(bench.runs, 5),
  );
  for (const side of ["isosplat", "nginx"] as const) {
    const name = `${what}, ${side}`;
    const late = loads[side].slice(1).map(({ p99Ms }) => p99Ms);
    if (options) {
      const gigabytes = rates[side].map((rate) => rate / 1e9);
      bench.report(
        name,
        "rate",
        "GB/s",
        gigabytes,
        side === "isosplat" ? { atLeast: 1 } : undefined,
      );
    } else {
      bench.report(name, "rate", "requests/s", rates[side]);
      bench.report(name, "99th percentile", "ms", late);
    }
    bench.report(name, "processor time of a request", "µs", costs[side].slice(1));
  }
  const ratio = (of: Record<"isosplat" | "nginx", number[]>) =>
    of.isosplat.map((value, i) => value / (of.nginx[i] ?? Number.NaN));
  const reach = atLeast === undefined ? undefined : { atLeast };
  bench.report(what, "rate, ratio to nginx", "×", ratio(rates), reach);
  bench.report(
    what,
    "processor time, ratio to nginx",
    "×",
    ratio(costs).slice(1),
    atMostCost === undefined ? undefined : { atMost: atMostCost },
  );
}

/** Chunks one by one, with and without TLS, and all chunks of an isovalue in one response. */
async function rates(bench: Bench, store: string, volume: string): Promise<void> {
  const plain = await serveStores(bench, [store]);
  const secure = await serveStores(bench, [store], { tls: true });
  const content = await contentPath(plain.url, volume);
  const surface = `${content}/chunks?isovalue=${isovalue}&level=0`;
  const frames = (await get(`${plain.url}${surface}`)).body;
  const all = chunksOf(frames, content);
  const chunks = [4096, 20_480].map((bytes) => ({ bytes, ...nearest(all, bytes) }));
  const bodies = chunks.map(({ bytes, body }) => [`${bytes}`, body] as const);
  const files = await serveFiles(bench, { ...Object.fromEntries(bodies), surface: frames });
  for (const { bytes, path, body } of chunks) {
    const what = `chunk of ${body.length} bytes`;
    await compare(
      bench,
      what,
      { atLeast: 1, atMostCost: 1 },
      {
        isosplat: [plain, plain.url + path],
        nginx: [files, `${files.url}/${bytes}`],
      },
    );
    await compare(
      bench,
      `${what}, TLS`,
      { atLeast: 0.9 },
      {
        isosplat: [secure, secure.tlsUrl + path],
        nginx: [files, `${files.tlsUrl}/${bytes}`],
      },
    );
  }
  await compare(
    bench,
    `${volume} at ${isovalue}, ${(frames.length / 1e6).toFixed(1)} MB`,
    {},
    { isosplat: [plain, plain.url + surface], nginx: [files, `${files.url}/surface`] },
    { connections: 1 },
  );
}

const request = (path: string) => `GET ${path} HTTP/1.1\r\nHost: localhost\r\n\r\n`;

/** 5,000 idle connections beside 100 busy ones. */
async function idleConnections(bench: Bench, host: Host, chunk: Chunk): Promise<void> {
  const count = 5000;
  const what = `${count} idle connections and 100 busy`;
  bench.say(what);
  const late = { without: [] as number[], with: [] as number[] };
  let served = 0;
  let resident = 0;
  const measure = async () =>
    (await load(bench, host.url + chunk.path, { connections: 100, seconds: 5 })).p99Ms;
  for (let round = 0; round < 3; ++round) {
    late.without.push(await measure());
    const crowd = new Crowd(host.url, idle);
    await crowd.open(count);
    late.with.push(await measure());
    resident = Math.max(resident, residentMegabytes(host.pid));
    served = await crowd.askAll(request(chunk.path));
    crowd.close();
  }
  bench.report(what, "idle ones that are answered then", "", served, { atLeast: count });
  bench.report(what, "RSS", "MB", resident, { atMost: 70 });
  bench.report(what, "99th percentile without them", "ms", late.without);
  bench.report(what, "99th percentile with them", "ms", late.with);
  const ratio = late.with.map((ms, i) => ms / (late.without[i] ?? Number.NaN));
  bench.report(what, "99th percentile, ratio", "×", ratio, { atMost: 3 });
}

async function openConnections(host: Host): Promise<number> {
  const metrics = (await get(`${host.url}/metrics`)).body.toString();
  return Number(metrics.match(/^isosplat_connections_open (\d+)/m)?.[1]);
}

/** Clients that occupy connections without reading or sending much. */
async function slowClients(bench: Bench, host: Host, chunk: Chunk, large: string): Promise<void> {
  const what = "2,000 slow readers, 500 slow headers";
  bench.say(what);
  const honest = { without: [] as number[], with: [] as number[] };
  // Longer than the time that a header may take (10 s).
  const measure = async () =>
    (await load(bench, host.url + chunk.path, { seconds: 12 })).requestsPerSecond;
  let seconds = 0;
  for (let round = 0; round < 2; ++round) {
    honest.without.push(await measure());
    const readers = new Crowd(host.url, slowReader(large));
    const writers = new Crowd(host.url, slowWriter(chunk.path));
    await readers.open(2000);
    await writers.open(500);
    honest.with.push(await measure());
    writers.close(); // otherwise they would connect again as soon as the server closes them
    const begin = performance.now();
    while ((await openConnections(host)) > 50 && seconds < 60) {
      await pause(500);
      seconds = (performance.now() - begin) / 1000;
    }
    bench.say(`${writers.dropped} slow headers were dropped meanwhile`);
    readers.close();
  }
  const ratio = honest.with.map((rate, i) => rate / (honest.without[i] ?? Number.NaN));
  bench.report(what, "honest clients' rate without them", "requests/s", honest.without);
  bench.report(what, "honest clients' rate with them", "requests/s", honest.with);
  bench.report(what, "honest clients' rate, ratio", "×", ratio, { atLeast: 0.9 });
  bench.report(what, "until all readers are dropped", "s", seconds, { atMost: 45 });
}

/** 10,000 stores in folders and subfolders: links to one file. */
async function manyStores(bench: Bench, store: string): Promise<void> {
  const count = 10_000;
  bench.say(`${count} stores`);
  const folder = join(bench.folder, "many");
  for (let i = 0; i < count; ++i) {
    const below = join(folder, `${i % 10}`, `${Math.floor(i / 10) % 10}`);
    if (i < 100) mkdirSync(below, { recursive: true });
    linkSync(store, join(below, `${i}.isosplat`));
  }
  const seconds: number[] = [];
  let host: Host | undefined;
  for (let run = 0; run < 3; ++run) {
    if (host) process.kill(host.pid);
    seconds.push(
      await bench.time(async () => {
        host = await serveStores(bench, [folder]);
      }),
    );
  }
  if (!host) return;
  bench.report(`${count} stores`, "ready after", "s", seconds, { atMost: 2 });
  const whole = `${host.url}/v1/volumes?limit=1000&offset=9000`;
  await untilItAnswers(whole);
  const page = await bench.time(() => get(whole));
  bench.report(`${count} stores`, "a page of 1,000 again", "ms", page * 1000);
  bench.report(`${count} stores`, "RSS", "MB", residentMegabytes(host.pid));
}

async function run(bench: Bench): Promise<void> {
  const build = async (volume: string, name: string) => {
    const store = join(bench.folder, `${name}.isosplat`);
    await bench.command(bench.isosplat, ["build", volume, "-o", store, "-q", "--no-thumbnail"]);
    return store;
  };
  await bench.command(bench.isosplat, ["demo", bench.folder, "--only", "bucky,mandelbulb"]);
  const bucky = await build(join(bench.folder, "bucky.nrrd"), "bucky");
  const mandelbulb = await build(join(bench.folder, "mandelbulb.nrrd"), "mandelbulb");
  if (process.env.ISOSPLAT_BENCH_SERVER_MINUTES) return mixedLoad(bench, bucky, mandelbulb);
  if (!bench.program("wrk") || !bench.program("nginx")) return;
  const bunny = bench.volume("bunny_ct_i16.nrrd");
  if (bunny) await rates(bench, await build(bunny, "bunny"), "bunny");

  const host = await serveStores(bench, [mandelbulb]);
  const content = await contentPath(host.url, "mandelbulb");
  const frames = await get(`${host.url}${content}/chunks?isovalue=100&level=0`);
  const chunk = nearest(chunksOf(frames.body, content), 4096);
  await idleConnections(bench, host, chunk);
  await slowClients(bench, host, chunk, `${content}/file`);
  await manyStores(bench, bucky);
  await mixedLoad(bench, bucky, mandelbulb);
}

export default {
  title: "the server: rates compared with nginx, many clients, slow clients, mixed load",
  run,
} satisfies Benchmark;
