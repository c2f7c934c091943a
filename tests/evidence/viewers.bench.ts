// 10,000 viewers. Visits are recorded with the page's client, and replayed through nginx, with the
// packages' configuration, in front of the server. Measures the requests that the cache answers,
// and those that reach the server.
import {
  existsSync,
  mkdirSync,
  readdirSync,
  readFileSync,
  rmSync,
  statSync,
  writeFileSync,
} from "node:fs";
import { join } from "node:path";
import type { Bench, Benchmark } from "../bench/harness/benchmark.ts";
import { buildStore } from "../bench/stream/serving.ts";
import { type RunningServer, serve } from "../browser/support/server.ts";
import {
  hasPackagedNginx,
  type PackagedNginx,
  type ProxyLine,
  startPackagedNginx,
} from "../support/packaged_nginx.ts";
import { Account } from "./viewers/account.ts";
import { audience } from "./viewers/audience.ts";
import { inOrder, itemsOf, newShares, type Outcome, simulate } from "./viewers/lru.ts";
import { OriginMeter, sum } from "./viewers/origin.ts";
import { hasChromium, openPage, pageRequests, withPage } from "./viewers/page_requests.ts";
import { record, type Wanted } from "./viewers/record.ts";
import { replay } from "./viewers/replay.ts";
import type { PlannedVisit, RecordedVisit } from "./viewers/requests.ts";
import { scripts } from "./viewers/scripted_visitor.ts";

/** The most popular first. */
const volumes = [
  ["engine", "engine.nhdr"],
  ["bonsai", "bonsai.nhdr"],
  ["bunny_ct_i16", "bunny_ct_i16.nrrd"],
  ["aneurysm", "aneurysm.nhdr"],
  ["mni152", "mni152.nii.gz"],
  ["lobster", "lobster.nhdr"],
  ["CT_AVM", "CT_AVM.nii.gz"],
  ["statueLeg", "statueLeg.nhdr"],
] as const;

/**
 * Breslau, Cao, Fan, Phillips, Shenker: Web Caching and Zipf-like Distributions, INFOCOM 1999, found
 * exponents of 0.64 to 0.83 in the requests to six proxies.
 */
const exponent = 0.8;
/** Different visits of each volume and scenario. */
const variants = 3;
const seed = 1;
const viewers = 10_000;
/** The time within which all of them arrive. */
const minutes = 10;
const link = { together: 20, roundTripMs: 40, megabitsPerSecond: 20 };

/**
 * Sizes of caches, as shares of the bytes of all stores. Only a tenth of the viewers visit with a
 * small cache, at the same rate.
 */
const caches = [
  { name: "unlimited cache", viewers: 1 },
  { name: "cache of 10 % of the stores", share: 0.1, viewers: 0.1 },
  { name: "cache of 1 % of the stores", share: 0.01, viewers: 0.1 },
] as const;
const calculated = [0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1];
/** Locations of a CDN, each with a separate cache. */
const places = 50;

const block = 4096;

interface CacheFiles {
  files: number;
  bytes: number;
}

/** The files of nginx's cache, whose manager may remove them meanwhile. */
function measureCache(folder: string): CacheFiles {
  let [files, bytes] = [0, 0];
  for (const name of readdirSync(folder, { recursive: true, encoding: "utf8" })) {
    const status = statSync(join(folder, name), { throwIfNoEntry: false });
    if (!status?.isFile()) continue;
    ++files;
    bytes += status.size;
  }
  return { files, bytes };
}

/** Starts the proxy in a new folder, so that its cache is empty. */
async function startProxy(bench: Bench, server: RunningServer, cacheBytes?: number) {
  const folder = join(bench.folder, "proxy");
  rmSync(folder, { recursive: true, force: true });
  mkdirSync(folder);
  const accessLog = join(folder, "log");
  writeFileSync(accessLog, "");
  const proxy = await startPackagedNginx(folder, new URL(server.url).port, {
    accessLog,
    ...(cacheBytes && { cacheSize: `${Math.round(cacheBytes / 1024)}k` }),
  });
  return { proxy, accessLog };
}

/** Visits of all volumes with a script each, whose gestures differ. */
function wantedVisits(names: readonly string[], count: number): Wanted[] {
  return names.flatMap((volume, v) =>
    Object.keys(scripts).flatMap((scenario, s) =>
      Array.from({ length: count }, (_, i) => ({
        volume,
        scenario,
        seed: 1000 * v + 100 * s + i + seed,
      })),
    ),
  );
}

const mean = (values: readonly number[]) =>
  values.reduce((all, value) => all + value, 0) / values.length;

/** Reports statistics of recorded visits, and the share of a visit that no other visit has. */
function reportVisits(bench: Bench, what: string, names: string[], visits: RecordedVisit[]): void {
  const bytes = visits.map(({ requests }) => requests.reduce((all, r) => all + r.bytes, 0) / 1e6);
  const counts = visits.map(({ requests }) => requests.length);
  const seconds = visits.map(({ duration }) => duration / 1000);
  const cancelled = visits.flatMap(({ requests }) =>
    requests.filter(({ cancelledAfter }) => cancelledAfter !== undefined),
  );
  bench.report(what, "recorded", "visits", visits.length);
  bench.report(what, "volumes", "", names.length);
  bench.report(what, "of a visit", "requests", counts);
  bench.report(what, "of a visit", "MB", bytes);
  bench.report(what, "of a visit", "s", seconds);
  const all = counts.reduce((sum, count) => sum + count, 0);
  bench.report(what, "given up, of requests", "%", (100 * cancelled.length) / all);
  reportNews(bench, what, names, visits);
}

/** Reports the share of a visit that no other visit of the volume has. */
function reportNews(bench: Bench, what: string, names: string[], visits: RecordedVisit[]): void {
  const news = names.map(
    (name) => 100 * mean(newShares(visits.filter(({ volume }) => volume === name))),
  );
  bench.report(what, "bytes of a visit that no other of the volume has", "%", news);
}

interface Replayed {
  account: Account;
  meter: OriginMeter;
  cache: CacheFiles;
  /** The maximum size of the files, measured every ten seconds. */
  mostCacheBytes: number;
}

async function replayThrough(
  proxy: PackagedNginx,
  server: RunningServer,
  visits: readonly PlannedVisit[],
): Promise<Replayed> {
  const account = new Account();
  let mostCacheBytes = 0;
  const watching = setInterval(() => {
    mostCacheBytes = Math.max(mostCacheBytes, measureCache(proxy.cacheFolder).bytes);
  }, 10_000);
  const meter = await OriginMeter.start(server.url);
  try {
    await replay(proxy, visits, account);
  } finally {
    clearInterval(watching);
    await meter.stop();
  }
  const cache = measureCache(proxy.cacheFolder);
  return { account, meter, cache, mostCacheBytes: Math.max(mostCacheBytes, cache.bytes) };
}

/** Checks that all requests have one outcome, and that all misses have reached the server. */
function checkCounts({ account, meter }: Replayed, visits: readonly PlannedVisit[]): void {
  const requests = visits.flatMap(({ visit }) => visit.requests);
  if (account.requests !== requests.length) {
    throw new Error(`expected ${requests.length} outcomes, found ${account.requests}`);
  }
  const { requests: served } = sum(meter.byRoute);
  const notHit = account.misses + account.passed;
  // For a range, nginx requests each piece of the file. Cancelled requests may have reached the
  // server.
  const ranges = requests.filter(({ range }) => range).length;
  const unsure = account.cancelled + account.failed + 2 * ranges;
  if (Math.abs(served - notHit) > unsure) {
    throw new Error(`expected ${notHit} ± ${unsure} requests of the server, found ${served}`);
  }
}

function reportReplay(bench: Bench, what: string, replayed: Replayed, minutes: number): void {
  const { account, meter, cache, mostCacheBytes } = replayed;
  const origin = sum(meter.byRoute);
  bench.report(what, "time of arrivals", "minutes", minutes);
  bench.report(what, "requests", "", account.requests);
  bench.report(what, "to the viewers", "GB", account.bytes / 1e9);
  bench.report(what, "hits, of requests", "%", (100 * account.hits) / account.requests);
  bench.report(what, "hits, of bytes", "%", (100 * account.hitBytes) / account.bytes);
  bench.report(what, "from the server", "requests", origin.requests);
  bench.report(what, "from the server", "MB", origin.bytes / 1e6);
  for (const [route, { requests, bytes }] of meter.byRoute) {
    if (requests === 0) continue;
    bench.report(what, `from the server, ${route}`, "requests", requests);
    bench.report(what, `from the server, ${route}`, "MB", bytes / 1e6);
  }
  const { rates, seconds } = meter;
  bench.report(what, "from the server, on average", "requests/s", origin.requests / seconds);
  bench.report(what, "from the server, at most", "requests/s", Math.max(...rates));
  bench.report(what, "refused (429)", "requests", account.refused);
  bench.report(what, "failed", "requests", account.failed);
  for (const [fault, count] of account.faults) bench.say(`${count} requests failed: ${fault}`);
  bench.report(what, "given up before an answer", "requests", account.cancelled);
  bench.report(what, "latency, median", "ms", account.latency(0.5));
  bench.report(what, "latency, 99th percentile", "ms", account.latency(0.99));
  bench.report(what, "sent late, 99th percentile", "ms", account.late(0.99));
  bench.report(what, "files of the cache, at the end", "MB", cache.bytes / 1e6);
  bench.report(what, "files of the cache, at the end", "", cache.files);
  bench.report(what, "files of the cache, at most", "MB", mostCacheBytes / 1e6);
}

function reportOutcome(bench: Bench, what: string, { requests, bytes, ...of }: Outcome): void {
  bench.report(what, "requests", "", requests);
  bench.report(what, "to the viewers", "GB", bytes / 1e9);
  bench.report(what, "hits, of requests", "%", (100 * of.hits) / requests);
  bench.report(what, "hits, of bytes", "%", (100 * of.hitBytes) / bytes);
  bench.report(what, "from the server", "MB", of.fetchedBytes / 1e6);
}

/**
 * Calculates the results of caches of other sizes and of several caches. For comparison, also
 * calculates that of the replay. `overhead`: bytes that an entry's file has beside the body.
 */
function calculate(
  bench: Bench,
  visits: readonly PlannedVisit[],
  replayed: number,
  storeBytes: number,
  overhead: number,
): void {
  const who = `${visits.length.toLocaleString("en")} viewers`;
  const requests = inOrder(visits);
  const sizeOf = (bytes: number) => block * Math.ceil((bytes + overhead) / block);
  for (const share of calculated) {
    const size = `cache of ${100 * share} % of the stores`;
    reportOutcome(
      bench,
      `${who}, calculated, ${size}`,
      simulate(requests, share * storeBytes, sizeOf),
    );
  }
  for (const count of new Set([replayed, visits.length])) {
    reportOutcome(
      bench,
      `${count.toLocaleString("en")} viewers, calculated, unlimited cache`,
      simulate(inOrder(visits.slice(0, count)), Infinity),
    );
  }
  // Viewers come in random order, so every 50th of them can be taken for one location.
  const each = Array.from({ length: places }, (_, place) =>
    simulate(inOrder(visits.filter((_, i) => i % places === place)), Infinity),
  );
  const total = each.reduce((all, one) => ({
    requests: all.requests + one.requests,
    bytes: all.bytes + one.bytes,
    hits: all.hits + one.hits,
    hitBytes: all.hitBytes + one.hitBytes,
    fetchedBytes: all.fetchedBytes + one.fetchedBytes,
    entries: all.entries + one.entries,
    cacheBytes: all.cacheBytes + one.cacheBytes,
  }));
  reportOutcome(bench, `${who}, calculated, ${places} unlimited caches`, total);
}

async function run(bench: Bench): Promise<void> {
  const replayed = Number(process.env.ISOSPLAT_BENCH_VIEWERS ?? viewers);
  if (!(replayed >= 10 && replayed <= viewers)) {
    throw new Error(`ISOSPLAT_BENCH_VIEWERS: expected 10 to ${viewers}, found ${replayed}`);
  }
  if (!hasPackagedNginx) {
    bench.skip("nginx", "not installed (.ci/install-packages --for test)");
    return;
  }
  const stores: string[] = [];
  const names: string[] = [];
  for (const [name, file] of volumes) {
    const volume = bench.volume(file);
    if (!volume) continue;
    stores.push(await buildStore(bench, volume, name));
    names.push(name);
  }
  if (names.length === 0) return;
  const storeBytes = stores.reduce((bytes, store) => bytes + statSync(store).size, 0);
  bench.report("stores", "size", "MB", storeBytes / 1e6);
  // biome-ignore format: options with their values
  const server = await serve(stores, 0, [
    "--allow-host", "volumes.example", "--connections-per-address", "0",
  ]);
  try {
    const recordings = await recordingsOf(bench, server, names);
    reportRecordings(bench, names, recordings);
    const visits = recordings.visits.map((visit) => withPage(visit, recordings.page));
    const lists = names.map((name) => visits.filter(({ volume }) => volume === name));
    const plan = audience({ viewers, minutes, visits: lists, exponent, seed });
    let overhead = 0;
    for (const cache of caches) {
      const count = Math.round(replayed * cache.viewers);
      const some = plan.slice(0, count);
      const size = "share" in cache ? cache.share * storeBytes : undefined;
      const what = `${count.toLocaleString("en")} viewers, ${cache.name}`;
      bench.say(what);
      const { proxy } = await startProxy(bench, server, size);
      try {
        const outcome = await replayThrough(proxy, server, some);
        checkCounts(outcome, some);
        reportReplay(bench, what, outcome, (minutes * count) / viewers);
        if (!size) overhead = overheadOf(outcome.cache, some);
      } finally {
        await proxy.stop();
      }
    }
    calculate(bench, plan, replayed, storeBytes, overhead);
  } finally {
    await server.stop();
  }
}

/** Bytes that nginx writes beside the body of an entry, on average. */
function overheadOf({ files, bytes }: CacheFiles, visits: readonly PlannedVisit[]): number {
  const bodies = new Map(
    visits.flatMap(({ visit }) => visit.requests.flatMap(itemsOf)).map((i) => [i.key, i.bytes]),
  );
  return (bytes - [...bodies.values()].reduce((all, one) => all + one, 0)) / files;
}

interface Recordings {
  /** The requests of the page besides those of its client. Empty without Chromium. */
  page: ReturnType<typeof pageRequests>;
  visits: RecordedVisit[];
  /** The first of each script, with a client that knows only HTTP/1.1. */
  batches: RecordedVisit[];
}

/**
 * Reads the recordings from the file that ISOSPLAT_BENCH_VIEWERS_VISITS names. If the file does not
 * exist, records visits and writes them to it.
 */
async function recordingsOf(
  bench: Bench,
  server: RunningServer,
  names: string[],
): Promise<Recordings> {
  const kept = process.env.ISOSPLAT_BENCH_VIEWERS_VISITS;
  if (kept && existsSync(kept)) {
    let text = readFileSync(kept, "utf8");
    // A store that is built again has another content id, and otherwise the same addresses.
    for (const name of names) {
      const answer = await fetch(`${server.url}v1/volumes/${name}`);
      const { contentId } = (await answer.json()) as { contentId: string };
      text = text.replaceAll(
        new RegExp(`(/v1/volumes/${name}/)[0-9a-f]{32}`, "g"),
        `$1${contentId}`,
      );
    }
    return JSON.parse(text) as Recordings;
  }
  const recordings = await recordAll(bench, server, names);
  if (kept) writeFileSync(kept, JSON.stringify(recordings));
  return recordings;
}

async function recordAll(
  bench: Bench,
  server: RunningServer,
  names: string[],
): Promise<Recordings> {
  const { proxy, accessLog } = await startProxy(bench, server);
  try {
    let page: Recordings["page"] = { requests: [], clientBegins: 0 };
    if (hasChromium) {
      bench.say("opening the page");
      await openPage(proxy, accessLog, names[0] ?? "");
      const lines = readFileSync(accessLog, "utf8").trim().split("\n");
      page = pageRequests(lines.map((line) => JSON.parse(line) as ProxyLine));
    } else bench.skip("requests of the page itself", "no Chromium");
    const wanted = wantedVisits(names, variants);
    bench.say(`recording ${wanted.length} visits`);
    const visits = await record(proxy, wanted, { ...link, isMultiplexed: true });
    const first = wantedVisits(names, 1);
    bench.say(`recording ${first.length} visits as over HTTP/1.1`);
    const batches = await record(proxy, first, { ...link, isMultiplexed: false });
    return { page, visits, batches };
  } finally {
    await proxy.stop();
  }
}

function reportRecordings(bench: Bench, names: string[], { page, visits, batches }: Recordings) {
  const bytes = page.requests.reduce((all, request) => all + request.bytes, 0);
  bench.report("the page itself", "of a visit", "requests", page.requests.length);
  bench.report("the page itself", "of a visit", "MB", bytes / 1e6);
  reportVisits(bench, "visits over HTTP/2", names, visits);
  const each = `${Object.keys(scripts).length} visits of each volume`;
  const isFirst = visits.filter((_, i) => i % variants === 0);
  reportNews(bench, `${each} over HTTP/2`, names, isFirst);
  reportVisits(bench, `${each} over HTTP/1.1`, names, batches);
}

export default {
  title: "10,000 viewers through nginx: hits of its cache, and what reaches the server",
  run,
} satisfies Benchmark;
