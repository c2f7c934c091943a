// Requests per second of the server's chunk route, and of nginx with the same bytes as files.
import { spawnSync } from "node:child_process";
import { mkdirSync, writeFileSync } from "node:fs";
import { userInfo } from "node:os";
import { join } from "node:path";
import { freePort } from "../support/nginx.ts";
import type { Bench, Benchmark } from "./harness/benchmark.ts";

interface Load {
  requestsPerSecond: number;
  p99Ms: number;
}

async function untilItAnswers(url: string): Promise<void> {
  for (let attempt = 0; attempt < 200; ++attempt) {
    try {
      if ((await fetch(url)).ok) return;
    } catch {
      // Not yet.
    }
    await new Promise((resolve) => setTimeout(resolve, 50));
  }
  throw new Error(`${url} does not answer`);
}

/** Runs nginx as the present user, because another one could not read the folder. */
const nginxConfiguration = (folder: string, port: number) => `
user ${userInfo().username}; daemon off; worker_processes 2; pid ${folder}/nginx.pid; error_log ${folder}/nginx.log;
events { worker_connections 1024; }
http {
  access_log off; sendfile on; tcp_nopush on; keepalive_requests 1000000;
  client_body_temp_path ${folder}/t1; proxy_temp_path ${folder}/t2; fastcgi_temp_path ${folder}/t3;
  uwsgi_temp_path ${folder}/t4; scgi_temp_path ${folder}/t5;
  server { listen 127.0.0.1:${port}; root ${folder}/files; add_header Cache-Control immutable; }
}`;

function load(wrk: string, url: string): Load {
  const run = spawnSync(wrk, ["-t2", "-c64", "-d3s", "--latency", url], { encoding: "utf8" });
  const rate = run.stdout.match(/Requests\/sec:\s+([\d.]+)/)?.[1];
  const [, p99, unit] = run.stdout.match(/99%\s+([\d.]+)(us|ms|s)/) ?? [];
  const failures = run.stdout.match(/Non-2xx|Socket errors/);
  if (!rate || !p99 || !unit || failures)
    throw new Error(`wrk ${url}:\n${run.stdout}${run.stderr}`);
  return {
    requestsPerSecond: Number(rate),
    p99Ms: Number(p99) * { us: 0.001, ms: 1, s: 1000 }[unit as "us" | "ms" | "s"],
  };
}

/** The address of a chunk, and its bytes. */
interface ChunkAnswer {
  url: string;
  body: Buffer;
}

/** A chunk of a level with about this number of bytes, from the frames of a range query. */
async function chunkNear(content: string, bytes: number): Promise<ChunkAnswer> {
  const answer = await fetch(`${content}/chunks?isovalue=-1e9..1e9&level=0`);
  if (!answer.ok) throw new Error(await answer.text());
  const frames = Buffer.from(await answer.arrayBuffer());
  let best: ChunkAnswer | undefined;
  for (let at = 0; at < frames.length; ) {
    const field = (i: number) => frames.readUInt32LE(at + 4 * i);
    const body = frames.subarray(at + 48, at + 48 + field(0));
    const place = `${field(2)}/${field(3)}.${field(4)}.${field(5)}/${field(6)}`;
    if (!best || Math.abs(body.length - bytes) < Math.abs(best.body.length - bytes)) {
      best = { url: `${content}/chunks/${place}`, body };
    }
    at += 48 + Math.ceil(field(0) / 16) * 16;
  }
  if (!best) throw new Error("the store has no chunk");
  return best;
}

async function run(bench: Bench): Promise<void> {
  const wrk = bench.program("wrk");
  const nginx = bench.program("nginx");
  if (!wrk) return;
  await bench.command(bench.isosplat, ["demo", bench.folder, "--only", "bucky"]);
  const store = join(bench.folder, "bucky.isosplat");
  await bench.command(bench.isosplat, ["build", join(bench.folder, "bucky.nrrd"), "-o", store]);

  const content = await serveVolume(bench, store);
  mkdirSync(join(bench.folder, "files"));
  const files = nginx ? await serveFiles(bench, nginx) : undefined;

  // All fetches happen before the measurement: wrk runs longer than the server keeps idle connections,
  // and fetch() would then reuse a closed one.
  const chunks: { wanted: number; chunk: ChunkAnswer }[] = [];
  for (const wanted of [4096, 65536]) {
    chunks.push({ wanted, chunk: await chunkNear(content, wanted) });
  }
  for (const { wanted, chunk } of chunks) {
    writeFileSync(join(bench.folder, "files", `${wanted}`), chunk.body);
    await compare(bench, wrk, chunk, files && `${files}/${wanted}`);
  }
}

/** Serves a store. Returns the address of its content. */
async function serveVolume(bench: Bench, store: string): Promise<string> {
  const port = await freePort();
  bench.start(bench.isosplat, ["serve", store, "--port", String(port), "--threads", "2"]);
  const base = `http://127.0.0.1:${port}`;
  await untilItAnswers(`${base}/healthz`);
  const info = (await (await fetch(`${base}/v1/volumes/bucky`)).json()) as { contentId: string };
  return `${base}/v1/volumes/bucky/${info.contentId}`;
}

/** Serves the folder `files` with nginx. Returns its address. */
async function serveFiles(bench: Bench, nginx: string): Promise<string> {
  const port = await freePort();
  const configuration = join(bench.folder, "nginx.conf");
  writeFileSync(configuration, nginxConfiguration(bench.folder, port));
  writeFileSync(join(bench.folder, "files/ready"), "ready");
  bench.start(nginx, ["-c", configuration, "-e", join(bench.folder, "nginx.log")]);
  await untilItAnswers(`http://127.0.0.1:${port}/ready`);
  return `http://127.0.0.1:${port}`;
}

/** Measures a chunk's route, and nginx with the same bytes, if there is an address of it. */
async function compare(
  bench: Bench,
  wrk: string,
  chunk: ChunkAnswer,
  file: string | undefined,
): Promise<void> {
  const what = `chunk of ${chunk.body.length} bytes`;
  const ours: Load[] = [];
  const theirs: Load[] = [];
  const measure = (loads: Load[], url: string): number => {
    loads.push(load(wrk, url));
    return loads.at(-1)?.requestsPerSecond ?? 0;
  };
  const both = await bench.interleave(
    {
      isosplat: () => measure(ours, chunk.url),
      nginx: () => (file ? measure(theirs, file) : 0),
    },
    Math.min(bench.runs, 5),
  );
  const report = (name: string, rates: number[], loads: Load[]): void => {
    const late = loads.slice(1).map((run) => run.p99Ms);
    bench.report(`${what}, ${name}`, "rate", "requests/s", rates);
    bench.report(`${what}, ${name}`, "99th percentile", "ms", late);
  };
  report("isosplat", both.isosplat, ours);
  if (!file) return;
  report("nginx", both.nginx, theirs);
  const ratios = both.isosplat.map((rate, i) => rate / (both.nginx[i] ?? Number.NaN));
  bench.report(what, "rate, ratio to nginx", "", ratios, { atLeast: 0.8 });
}

export default {
  title: "requests per second, compared with nginx",
  run,
} satisfies Benchmark;
