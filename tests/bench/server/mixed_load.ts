// Clients of every kind for a while, and faults. Checks that every byte is right, and that no
// resource grows.
import { createHash } from "node:crypto";
import { copyFileSync, openSync, readSync, renameSync } from "node:fs";
import { Agent } from "node:http";
import { connect } from "node:net";
import { join } from "node:path";
import type { Bench } from "../harness/benchmark.ts";
import { type Chunk, chunksOf, contentPath } from "./chunks.ts";
import { descriptors, get, residentMegabytes, serveStores } from "./hosts.ts";

/** Duration in minutes. */
const minutes = Number(process.env.ISOSPLAT_BENCH_SERVER_MINUTES ?? 2);

const pause = (ms: number) => new Promise<void>((resolve) => setTimeout(resolve, ms));
const digest = (bytes: Buffer) => createHash("sha1").update(bytes).digest("base64");

/** Numbers in [0, 1), the same in each run. */
function randomNumbers(seed: number): () => number {
  let state = seed >>> 0;
  return () => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return state / 2 ** 32;
  };
}

interface Counts {
  right: number;
  wrong: number;
  faults: number;
}

/** Bytes that a server must refuse. */
const malformed = [
  "GET / HTTP/1.1\r\n\r\n",
  "GET /%00 HTTP/1.1\r\nHost: localhost\r\n\r\n",
  "POST /v1/volumes HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n",
  `GET /${"x".repeat(20_000)} HTTP/1.1\r\nHost: localhost\r\n\r\n`,
  "\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03",
];

/**
 * A client that closes its connection within the header or the body, or after bytes that are not a
 * request.
 */
async function misbehave(port: number, path: string, random: () => number): Promise<void> {
  const kind = Math.floor(random() * 3);
  await new Promise<void>((resolve) => {
    const socket = connect(port, "127.0.0.1", () => {
      if (kind === 0) socket.write(`GET ${path} HTTP/1.1\r\nHost: loc`);
      if (kind === 1) socket.write(`GET ${path} HTTP/1.1\r\nHost: localhost\r\n\r\n`);
      if (kind === 2) socket.write(malformed[Math.floor(random() * malformed.length)] ?? "");
    });
    const end = () => socket.resetAndDestroy();
    socket.once("data", end).on("error", () => {});
    socket.on("close", () => resolve());
    setTimeout(end, 50);
  });
}

/** Clients of one store, whose file is `path`. */
class Clients {
  readonly counts: Counts = { right: 0, wrong: 0, faults: 0 };
  readonly #server: string;
  readonly #path: string;
  readonly #content: string;
  readonly #chunks: readonly Chunk[];
  readonly #known = new Map<string, string>();

  private constructor(server: string, path: string, content: string, chunks: readonly Chunk[]) {
    this.#server = server;
    this.#path = path;
    this.#content = content;
    this.#chunks = chunks;
  }

  static async create(server: string, name: string, path: string): Promise<Clients> {
    const content = await contentPath(server, name);
    const frames = await get(`${server}${content}/chunks?isovalue=-1e9..1e9&level=0`);
    return new Clients(server, path, content, chunksOf(frames.body, content));
  }

  /** Sends requests until `end`, one after another. */
  async work(end: number, random: () => number): Promise<void> {
    const agent = new Agent({ keepAlive: true, maxSockets: 1 });
    const file = openSync(this.#path, "r");
    while (Date.now() < end) {
      const kind = random();
      if (kind < 0.05) {
        ++this.counts.faults;
        const { port } = new URL(this.#server);
        await misbehave(Number(port), `${this.#content}/file`, random);
      } else if (kind < 0.7) {
        const chunk = this.#chunks[Math.floor(random() * this.#chunks.length)];
        if (chunk) await this.#ask(chunk.path, agent, digest(chunk.body));
      } else if (kind < 0.85) {
        const expected = Buffer.alloc(1 + Math.floor(random() * 100_000));
        const first = Math.floor(random() * 200_000);
        const bytes = readSync(file, expected, 0, expected.length, first);
        const range = `bytes=${first}-${first + bytes - 1}`;
        await this.#ask(`${this.#content}/file`, agent, digest(expected.subarray(0, bytes)), range);
      } else {
        const paths = [
          `${this.#content}/chunks?isovalue=${Math.floor(random() * 8) * 30}&level=1`,
          `${this.#content}/samples?isovalue=${Math.floor(random() * 4) * 50}.5&level=1`,
          `${this.#content}/header`,
          `${this.#content}/isovalues?isovalue=0..200`,
        ];
        // All responses to a request must have the same content.
        await this.#ask(paths[Math.floor(random() * paths.length)] ?? "", agent);
      }
    }
    agent.destroy();
  }

  async #ask(path: string, agent: Agent, expected?: string, range?: string): Promise<void> {
    const answer = await get(`${this.#server}${path}`, agent, range ? { Range: range } : {}).catch(
      () => undefined,
    );
    if (answer?.status === 503) return; // busy
    const found = answer && answer.status < 300 ? digest(answer.body) : "none";
    const known = expected ?? this.#known.get(path) ?? found;
    if (found === "none" || found !== known) ++this.counts.wrong;
    else ++this.counts.right;
    this.#known.set(path, known);
  }
}

/** Replaces a served store repeatedly. Its readers must never see a mixture of two stores. */
async function replaceAndRead(
  server: string,
  path: string,
  versions: readonly string[],
  end: number,
  counts: Counts,
): Promise<void> {
  const expected = new Map<string, string>();
  for (let i = 0; Date.now() < end; ++i) {
    copyFileSync(versions[i % versions.length] ?? "", `${path}.new`);
    renameSync(`${path}.new`, path);
    for (let read = 0; read < 20 && Date.now() < end; ++read) {
      try {
        const content = await contentPath(server, "replaced");
        const answer = await get(`${server}${content}/file`);
        if (answer.status === 200) {
          const found = digest(answer.body);
          if (found === (expected.get(content) ?? found)) ++counts.right;
          else ++counts.wrong;
          expected.set(content, found);
        } else if (answer.status !== 404 && answer.status !== 503) {
          ++counts.wrong;
        }
      } catch {
        ++counts.wrong;
      }
      await pause(20);
    }
  }
}

export async function mixedLoad(bench: Bench, store: string, other: string): Promise<void> {
  const replaced = join(bench.folder, "replaced.isosplat");
  copyFileSync(store, replaced);
  const host = await serveStores(bench, [store, replaced]);
  const name = (store.split("/").at(-1) ?? "").replace(".isosplat", "");
  const clients = await Clients.create(host.url, name, store);
  const before = descriptors(host.pid);
  const begin = Date.now();
  const end = begin + minutes * 60_000;
  const work = Array.from({ length: 8 }, (_, i) => clients.work(end, randomNumbers(i + 1)));
  work.push(replaceAndRead(host.url, replaced, [other, store], end, clients.counts));
  const held: number[] = [];
  while (Date.now() < end) {
    await pause((minutes * 60_000) / 60);
    held.push(residentMegabytes(host.pid));
  }
  await Promise.all(work);
  await pause(3000); // the server closes the aborted connections
  const what = `${minutes} min of mixed load`;
  const { right, wrong, faults } = clients.counts;
  bench.report(what, "answers compared", "", right);
  bench.report(what, "wrong answers", "", wrong, { atMost: 0 });
  bench.report(what, "clients that broke off", "", faults);
  const third = Math.floor(held.length / 3);
  const mean = (part: number[]) => part.reduce((sum, value) => sum + value, 0) / part.length;
  bench.report(what, "RSS, in the last third", "MB", mean(held.slice(-third)));
  // The first third is not counted, because it fills caches.
  const growth = mean(held.slice(-third)) / mean(held.slice(third, 2 * third));
  bench.report(what, "RSS, last third by the second", "×", growth, { atMost: 1.05 });
  bench.report(what, "descriptors, more than before", "", descriptors(host.pid) - before, {
    atMost: 2,
  });
}
