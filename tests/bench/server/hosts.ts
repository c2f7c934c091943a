// The servers that are compared: isosplat serve, and nginx with the same bytes as files.
import { mkdirSync, readdirSync, readFileSync, writeFileSync } from "node:fs";
import { type Agent, type IncomingHttpHeaders, request } from "node:http";
import { userInfo } from "node:os";
import { join } from "node:path";
import { makeCertificate } from "../../support/certificate.ts";
import { freePort } from "../../support/nginx.ts";
import type { Bench } from "../harness/benchmark.ts";

export interface Host {
  /** Without a slash at the end. */
  url: string;
  tlsUrl: string;
  pid: number;
}

export interface Answer {
  status: number;
  headers: IncomingHttpHeaders;
  body: Buffer;
}

/** Sends a request on a new connection, or on one of `agent`. */
export function get(
  url: string,
  agent: Agent | false = false,
  headers: Record<string, string> = {},
): Promise<Answer> {
  return new Promise((resolve, reject) => {
    const asked = request(url, { agent, headers }, (answer) => {
      const parts: Buffer[] = [];
      answer.on("data", (part: Buffer) => parts.push(part));
      answer.on("error", reject);
      answer.on("end", () =>
        resolve({
          status: answer.statusCode ?? 0,
          headers: answer.headers,
          body: Buffer.concat(parts),
        }),
      );
    });
    asked.on("error", reject).end();
  });
}

/** Waits until a URL answers with 200. */
export async function untilItAnswers(url: string, pauseMs = 20): Promise<void> {
  for (const end = Date.now() + 60_000; Date.now() < end; ) {
    const answer = await get(url).catch(() => undefined);
    if (answer?.status === 200) return;
    await new Promise((resolve) => setTimeout(resolve, pauseMs));
  }
  throw new Error(`${url} does not answer`);
}

/** Options that allow enough connections for all benchmarks, even from one address. */
const manyConnections = ["--connections", "12000", "--connections-per-address", "0"];

/** Serves stores. `limits: []` selects the default limits of the server. */
export async function serveStores(
  bench: Bench,
  stores: readonly string[],
  { tls = false, limits = manyConnections } = {},
): Promise<Host> {
  const port = await freePort();
  const files = tls && makeCertificate(bench.folder, "localhost");
  const secure = files ? ["--tls-cert", files.certificate, "--tls-key", files.key] : [];
  // biome-ignore format: options with their values
  const child = bench.start(bench.isosplat, [
    "serve", ...stores, "--port", String(port), "--threads", "2",
    ...limits, ...secure,
  ]);
  child.stdout?.resume();
  child.stderr?.resume();
  const host = {
    url: `http://127.0.0.1:${port}`,
    tlsUrl: `https://127.0.0.1:${port}`,
    pid: child.pid ?? 0,
  };
  if (tls) await new Promise((resolve) => child.stdout?.once("data", resolve));
  else await untilItAnswers(`${host.url}/readyz`);
  return host;
}

/** Runs nginx as the present user, because another one could not read the folder. */
export async function serveFiles(bench: Bench, files: Record<string, Buffer>): Promise<Host> {
  const nginx = bench.program("nginx");
  if (!nginx) throw new Error("nginx is not installed (.ci/install-packages --for bench)");
  const folder = join(bench.folder, "nginx");
  mkdirSync(join(folder, "files"), { recursive: true });
  for (const [name, content] of Object.entries({ ...files, ready: Buffer.from("ready") })) {
    writeFileSync(join(folder, "files", name), content);
  }
  const port = await freePort();
  const tlsPort = await freePort();
  const keys = makeCertificate(bench.folder, "localhost");
  const configuration = join(folder, "nginx.conf");
  writeFileSync(
    configuration,
    `user ${userInfo().username}; daemon off; worker_processes 2; pid ${folder}/nginx.pid; error_log ${folder}/nginx.log;
    events { worker_connections 4096; }
    http {
      access_log off; sendfile on; tcp_nopush on; keepalive_requests 1000000000;
      client_body_temp_path ${folder}/t1; proxy_temp_path ${folder}/t2; fastcgi_temp_path ${folder}/t3;
      uwsgi_temp_path ${folder}/t4; scgi_temp_path ${folder}/t5;
      server {
        listen 127.0.0.1:${port}; listen 127.0.0.1:${tlsPort} ssl;
        ssl_certificate ${keys.certificate}; ssl_certificate_key ${keys.key};
        root ${folder}/files; add_header Cache-Control immutable;
      }
    }`,
  );
  const child = bench.start(nginx, ["-c", configuration, "-e", join(folder, "nginx.log")]);
  const url = `http://127.0.0.1:${port}`;
  await untilItAnswers(`${url}/ready`);
  return { url, tlsUrl: `https://127.0.0.1:${tlsPort}`, pid: child.pid ?? 0 };
}

/** Resident memory of a process in MB. */
export function residentMegabytes(pid: number): number {
  const status = readFileSync(`/proc/${pid}/status`, "utf8");
  return (Number(status.match(/VmRSS:\s+(\d+)/)?.[1]) * 1024) / 1e6;
}

/** Open files and sockets of a process. */
export const descriptors = (pid: number): number => readdirSync(`/proc/${pid}/fd`).length;

/** Processor time of a process and its children so far, in seconds. */
export function processorSeconds(pid: number): number {
  const children = readFileSync(`/proc/${pid}/task/${pid}/children`, "utf8").split(" ");
  let ticks = 0;
  for (const each of [pid, ...children.filter(Boolean)]) {
    const fields = readFileSync(`/proc/${each}/stat`, "utf8").split(") ")[1]?.split(" ") ?? [];
    ticks += Number(fields[11]) + Number(fields[12]);
  }
  return ticks / 100;
}
