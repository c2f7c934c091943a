// Floods: measures the service for another client while some clients keep the server busy.
import { type ChildProcess, spawn } from "node:child_process";
import { linkSync, mkdirSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { visit } from "./floods/visitor.ts";
import type { Bench, Benchmark } from "./harness/benchmark.ts";
import { chunksOf, contentPath, nearest } from "./server/chunks.ts";
import { get, type Host, serveStores } from "./server/hosts.ts";

const pause = (ms: number) => new Promise<void>((resolve) => setTimeout(resolve, ms));

/** Duration of one measurement, longer than the time until a full server closes slow clients. */
const seconds = 6;

interface Flood {
  /** Its name in the table. */
  what: string;
  /** The kind of flood (floods/flooder.ts). */
  kind: string;
  host: Host;
  /** The path that the flooder requests. */
  target: string;
  /** The URL that the visitor requests. */
  url: string;
}

/** Floods the server until the returned function is called. */
async function begin(bench: Bench, { kind, host, target }: Flood): Promise<() => Promise<void>> {
  const port = new URL(host.url).port;
  const tsx = join(bench.root, "node_modules/.bin/tsx");
  const program = join(bench.root, "tests/bench/floods/flooder.ts");
  const child: ChildProcess = spawn("nice", ["-n", "19", tsx, program, kind, port, target], {
    stdio: ["pipe", "ignore", "inherit"],
  });
  await pause(3000);
  if (child.exitCode !== null) throw new Error(`the flood of ${kind} has ended early`);
  return () =>
    new Promise((resolve) => {
      child.once("exit", () => resolve());
      child.stdin?.end();
    });
}

/** The visitor's rate without and with the flood, in turn. */
async function measure(bench: Bench, flood: Flood): Promise<void> {
  bench.say(flood.what);
  const rates = { without: [] as number[], with: [] as number[] };
  await visit(bench, flood.url, 1);
  for (let run = 0; run < Math.min(bench.runs, 3); ++run) {
    rates.without.push(await visit(bench, flood.url, seconds));
    const end = await begin(bench, flood);
    rates.with.push(await visit(bench, flood.url, seconds));
    await end();
    await pause(1000); // the server closes the remaining connections
  }
  const ratio = rates.with.map((rate, i) => rate / (rates.without[i] ?? Number.NaN));
  bench.report(flood.what, "another client's rate without", "requests/s", rates.without);
  bench.report(flood.what, "another client's rate with", "requests/s", rates.with);
  bench.report(flood.what, "ratio", "×", ratio, { atLeast: 0.9 });
}

/** 20,000 links to a small store, and a file of 20 patterns, so that each may be read by anyone. */
async function serveMany(bench: Bench, store: string): Promise<Host> {
  const folder = join(bench.folder, "many");
  for (let i = 0; i < 20_000; ++i) {
    const below = join(folder, `${i % 20}`);
    if (i < 20) mkdirSync(below, { recursive: true });
    linkSync(store, join(below, `s${i}.isosplat`));
  }
  const patterns = Array.from({ length: 20 }, (_, i) => `anyone ${i}~*\n`).join("");
  const file = join(bench.folder, "tokens");
  writeFileSync(file, patterns);
  return serveStores(bench, [folder], { limits: ["--token-file", file] });
}

async function run(bench: Bench): Promise<void> {
  if (!bench.program("wrk")) return;
  await bench.command(bench.isosplat, ["demo", bench.folder, "--only", "bucky,mandelbulb"]);
  const build = async (name: string) => {
    const store = join(bench.folder, `${name}.isosplat`);
    const volume = join(bench.folder, `${name}.nrrd`);
    await bench.command(bench.isosplat, ["build", volume, "-o", store, "-q", "--no-thumbnail"]);
    return store;
  };
  const mandelbulb = await build("mandelbulb");
  const plain = await serveStores(bench, [mandelbulb], { limits: [] });
  const secure = await serveStores(bench, [mandelbulb], { limits: [], tls: true });
  const content = await contentPath(plain.url, "mandelbulb");
  const frames = await get(`${plain.url}${content}/chunks?isovalue=100&level=0`);
  const chunk = nearest(chunksOf(frames.body, content), 4096).path;
  const visited = { host: plain, url: plain.url + chunk };

  const floods: Flood[] = [
    {
      what: "1,024 slow readers of four addresses, 100 B/s each",
      kind: "readers",
      target: `${content}/file`,
      ...visited,
    },
    {
      what: "1,024 slow headers of four addresses, 1 B/s each",
      kind: "headers",
      target: chunk,
      ...visited,
    },
    {
      what: "1,500 stalled handshakes/s of eight addresses, HTTP",
      kind: "handshakes",
      target: chunk,
      ...visited,
    },
    {
      what: "1,500 stalled handshakes/s of eight addresses, TLS",
      kind: "handshakes",
      target: chunk,
      host: secure,
      url: secure.tlsUrl + chunk,
    },
    {
      what: "one address with 64 connections that ask for chunks",
      kind: "greedy",
      target: chunk,
      ...visited,
    },
    {
      what: "40 loops of samples of one address",
      kind: "loops",
      target: `${content}/samples?isovalue=100`,
      ...visited,
    },
  ];
  for (const flood of floods) await measure(bench, flood);

  const many = await serveMany(bench, await build("bucky"));
  const first = await contentPath(many.url, "0~s0");
  const all = await get(`${many.url}${first}/chunks?isovalue=100&level=0`);
  await measure(bench, {
    what: "4 × 360 pipelined /healthz per second, 20,000 stores",
    kind: "pipelines",
    target: "/healthz",
    host: many,
    url: many.url + nearest(chunksOf(all.body, first), 4096).path,
  });
}

export default {
  title: "floods: another client's rate while some clients keep the server busy",
  run,
} satisfies Benchmark;
