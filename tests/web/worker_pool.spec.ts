// Decoding workers that die: their chunks are reported, and other workers replace them, up to a limit.
import { afterEach, beforeAll, beforeEach, describe, expect, it, vi } from "vitest";
import { type Chunk, type Core, CoreError, type DecodedChunk } from "../../web/core/index.ts";
import type { WorkerRequest, WorkerStart } from "../../web/stream/decode_worker.ts";
import { WorkerPool } from "../../web/stream/worker_pool.ts";
import { core as load, openWhole, storeBytes } from "./fixture.ts";

let core: Core;
let chunks: { chunk: Chunk; bytes: Uint8Array }[];

beforeAll(async () => {
  core = await load();
  const file = storeBytes();
  chunks = openWhole(core, file)
    .chunksFor(0, 100, 100)
    .map((chunk) => ({ chunk, bytes: file.slice(chunk.offset, chunk.offset + chunk.bytes) }));
});

/** A worker with the code of the real one, which decodes when the test tells it to. */
class StubWorker {
  static all: StubWorker[] = [];
  onmessage: ((event: { data: unknown }) => void) | null = null;
  onerror: ((event: { message: string; preventDefault(): void }) => void) | null = null;
  isStarted = false;
  isTerminated = false;
  readonly requests: WorkerRequest[] = [];

  constructor() {
    StubWorker.all.push(this);
  }

  postMessage(message: WorkerStart | WorkerRequest): void {
    if ("program" in message) this.isStarted = true;
    else this.requests.push(message);
  }

  terminate(): void {
    this.isTerminated = true;
  }

  /** Answers the oldest request. */
  answer(): void {
    const request = this.requests.shift();
    if (!request) throw new Error("the worker was asked for nothing");
    const data = request.map(({ id, job, bytes }) => ({
      id,
      decoded: core.decodeChunk(job, bytes),
    }));
    this.onmessage?.({ data });
  }

  crash(message = "out of memory"): void {
    this.onerror?.({ message, preventDefault: () => {} });
  }

  static get living(): StubWorker[] {
    return StubWorker.all.filter((worker) => !worker.isTerminated);
  }
}

beforeEach(() => {
  StubWorker.all = [];
  vi.stubGlobal("Worker", StubWorker);
});
afterEach(() => {
  vi.unstubAllGlobals();
});

const never = new AbortController().signal;

/** Sends the n-th chunk through the pool, and records the result. */
function decode(pool: WorkerPool, n: number, signal = never) {
  const at = chunks[n % chunks.length];
  if (!at) throw new Error("the fixture has no chunks");
  const state: { decoded?: DecodedChunk; error?: unknown } = {};
  const done = pool.decode(at.chunk, at.bytes.slice(), signal).then(
    (decoded) => {
      state.decoded = decoded;
    },
    (error: unknown) => {
      state.error = error;
    },
  );
  return { state, done, expected: () => core.decodeChunk(at.chunk, at.bytes) };
}

/** Waits until the workers have received the module. */
const begun = () =>
  vi.waitFor(() => expect(StubWorker.living.every((w) => w.isStarted)).toBe(true));

/** The stubs do not look at their module. */
const renderer = Promise.resolve({});

describe("a worker that dies", () => {
  it("rejects its jobs, and another worker replaces it and takes the waiting ones", async () => {
    const pool = new WorkerPool({ workers: 1, renderer });
    await begun();
    const jobs = [0, 1, 2].map((n) => decode(pool, n));
    const [first] = StubWorker.all;
    expect(first?.requests.length).toBe(2);
    first?.answer();
    jobs.push(decode(pool, 3));
    first?.crash("wasm trap");
    expect(first?.isTerminated).toBe(true);
    await Promise.all([jobs[1]?.done, jobs[2]?.done]);
    for (const lost of [jobs[1], jobs[2]]) {
      expect(lost?.state.error).toBeInstanceOf(CoreError);
      expect(lost?.state.error).toMatchObject({
        status: "worker_lost",
        message: expect.stringContaining("wasm trap"),
      });
    }
    await begun();
    expect(StubWorker.all.length).toBe(2);
    const [second] = StubWorker.living;
    expect(second?.isStarted).toBe(true);
    second?.answer();
    await Promise.all([jobs[0]?.done, jobs[3]?.done]);
    for (const good of [jobs[0], jobs[3]]) expect(good?.state.decoded).toEqual(good?.expected());
    pool.close();
    expect(StubWorker.living).toEqual([]);
  });

  it("does not affect the jobs of others", async () => {
    const pool = new WorkerPool({ workers: 2, renderer });
    await begun();
    const jobs = [0, 1, 2, 3].map((n) => decode(pool, n));
    StubWorker.all[0]?.crash();
    await begun();
    const [survivor] = StubWorker.living;
    survivor?.answer();
    survivor?.answer();
    await Promise.all(jobs.map((job) => job.done));
    expect(jobs.map((job) => job.state.error !== undefined)).toEqual([true, true, false, false]);
    expect(StubWorker.living.length).toBe(2);
    pool.close();
  });

  it("is replaced at once a few times, and then only for the next job", async () => {
    const pool = new WorkerPool({ workers: 1, renderer });
    for (let deaths = 0; StubWorker.living.length > 0; ++deaths) {
      if (deaths > 100) throw new Error("workers are started for ever");
      await begun();
      const job = decode(pool, deaths);
      StubWorker.living[0]?.crash(`death ${deaths}`);
      await job.done;
      expect((job.state.error as CoreError).message).toContain(`death ${deaths}`);
    }
    expect(StubWorker.all.length).toBe(4);
    // A repeated request comes later, when memory may be available again.
    const late = decode(pool, 0);
    await begun();
    StubWorker.living[0]?.crash("still");
    await late.done;
    expect((late.state.error as CoreError).status).toBe("worker_lost");
    expect(StubWorker.living).toEqual([]);
    expect(StubWorker.all.length).toBe(5);
    const good = decode(pool, 0);
    await begun();
    StubWorker.living[0]?.answer();
    await good.done;
    expect(good.state.decoded).toEqual(good.expected());
    pool.close();
  });

  it("fails the waiting jobs if it was the last", async () => {
    const pool = new WorkerPool({ workers: 1, renderer });
    for (let death = 0; death < 3; ++death) StubWorker.living[0]?.crash();
    await begun();
    const jobs = Array.from({ length: 6 }, (_, n) => decode(pool, n)); // two begun, four wait
    StubWorker.living[0]?.crash("the last");
    await Promise.all(jobs.map((job) => job.done));
    for (const { state } of jobs) expect((state.error as Error).message).toContain("the last");
    pool.close();
  });

  it("is not replaced once the pool is closed, and no answer follows", async () => {
    const pool = new WorkerPool({ workers: 1, renderer });
    await begun();
    const jobs = [0, 1, 2].map((n) => decode(pool, n));
    const [worker] = StubWorker.all;
    pool.close();
    worker?.crash();
    worker?.answer();
    await Promise.all(jobs.map((job) => job.done));
    for (const { state } of jobs) expect(state.error).toMatchObject({ name: "AbortError" });
    expect(StubWorker.all.length).toBe(1);
  });
});

it("sends small chunks that wait together, and large ones alone", async () => {
  const pool = new WorkerPool({ workers: 1, renderer });
  await begun();
  const [worker] = StubWorker.all;
  const [small] = [...chunks].sort((a, b) => a.bytes.length - b.bytes.length);
  if (!worker || !small) throw new Error("the fixture has no chunks");
  const padding = 40 * 1024;
  const large = new Uint8Array(small.bytes.length + padding);
  const jobs = Array.from({ length: 70 }, () =>
    pool.decode(small.chunk, small.bytes.slice(), new AbortController().signal),
  );
  void pool.decode(small.chunk, large, never).catch(() => {});
  const sizes: number[] = [];
  for (;;) {
    const [request] = worker.requests;
    if (!request || request[0]?.bytes.length === large.length) break;
    sizes.push(request.length);
    worker.answer();
  }
  expect(worker.requests.map((request) => request.length)).toEqual([1]);
  const most = Math.max(1, Math.min(32, Math.floor((32 * 1024) / small.bytes.length)));
  expect(Math.max(...sizes)).toBe(most);
  expect(sizes.reduce((sum, size) => sum + size, 0)).toBe(70);
  const expected = core.decodeChunk(small.chunk, small.bytes);
  for (const job of jobs) expect(await job).toEqual(expected);
  pool.close();
});

it("a job that is aborted while it waits is never given to a worker", async () => {
  const pool = new WorkerPool({ workers: 1, renderer });
  await begun();
  const jobs = [0, 1].map((n) => decode(pool, n));
  const ending = new AbortController();
  const waiting = decode(pool, 2, ending.signal);
  ending.abort(new Error("no longer needed"));
  await waiting.done;
  expect(waiting.state.error).toMatchObject({ message: "no longer needed" });
  StubWorker.all[0]?.answer();
  StubWorker.all[0]?.answer();
  await Promise.all(jobs.map((job) => job.done));
  expect(StubWorker.all[0]?.requests).toEqual([]);
  pool.close();
});

describe("a worker that does not start", () => {
  it("fails the waiting jobs if its constructor throws", async () => {
    vi.stubGlobal(
      "Worker",
      class {
        constructor() {
          throw new Error("insecure");
        }
      },
    );
    const pool = new WorkerPool({ workers: 1, renderer });
    const job = decode(pool, 0);
    await job.done;
    expect(job.state.error).toMatchObject({ status: "worker_lost" });
    expect((job.state.error as CoreError).message).toContain("insecure");
    pool.close();
  });

  it("fails the waiting jobs if its program is missing, and names it", async () => {
    const pool = new WorkerPool({ workers: 1, renderer });
    const jobs: ReturnType<typeof decode>[] = [];
    while (StubWorker.living.length > 0) {
      jobs.push(decode(pool, 0));
      StubWorker.living[0]?.crash("");
    }
    await Promise.all(jobs.map((job) => job.done));
    expect(StubWorker.all.length).toBe(4);
    const message = (jobs[3]?.state.error as CoreError | undefined)?.message;
    expect(message).toMatch(/expected \S+decode_worker\.ts/);
    pool.close();
  });

  it("fails the waiting jobs after 4 s without an answer, and works once there is one", async () => {
    vi.useFakeTimers();
    try {
      const pool = new WorkerPool({ workers: 1, renderer });
      await vi.advanceTimersByTimeAsync(0);
      const jobs = [0, 1, 2].map((n) => decode(pool, n)); // two begun, one waits
      await vi.advanceTimersByTimeAsync(3900);
      expect(jobs.map(({ state }) => state.error)).toEqual([undefined, undefined, undefined]);
      await vi.advanceTimersByTimeAsync(200);
      for (const { state } of jobs) {
        expect(state.error).toMatchObject({ status: "worker_lost" });
        expect((state.error as CoreError).message).toContain("no worker has answered for 4 s");
      }
      const next = decode(pool, 0);
      await next.done;
      expect(next.state.error).toMatchObject({ status: "worker_lost" });
      StubWorker.living[0]?.answer();
      const good = decode(pool, 1);
      StubWorker.living[0]?.answer(); // the job that had been given up
      StubWorker.living[0]?.answer();
      await good.done;
      expect(good.state.decoded).toEqual(good.expected());
      pool.close();
    } finally {
      vi.useRealTimers();
    }
  });
});
