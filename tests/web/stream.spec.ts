import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { afterAll, afterEach, beforeAll, beforeEach, describe, expect, test } from "vitest";
import type { Core } from "../../web/core/index.ts";
import { FileSource, ServerSource, type Source, StreamError } from "../../web/stream/index.ts";
import { type RunningServer, serve } from "../browser/support/server.ts";
import { FaultProxy, fetchedTwice } from "../support/fault_proxy.ts";
import { type Nginx, nginx } from "../support/nginx.ts";
import { clockThatJumps, passTime } from "./fake_clock.ts";
import { core as load, storeBytes } from "./fixture.ts";
import { Harness, view } from "./stream_harness.ts";

/** The folder of the store. The real server and nginx serve it, each behind a proxy. */
let folder: string;
let isosplat: RunningServer;
let host: Nginx;
let core: Core;
let server: FaultProxy;
let harness: Harness;

clockThatJumps();
beforeAll(async () => {
  core = await load();
  folder = mkdtempSync(join(tmpdir(), "isosplat-stream-"));
  writeFileSync(join(folder, "test.isosplat"), storeBytes());
  writeFileSync(join(folder, "zeros.isosplat"), new Uint8Array(70_000));
  isosplat = await serve([folder]);
  host = await nginx({ folders: [folder] });
});

afterAll(async () => {
  await isosplat?.stop();
  await host?.stop();
  rmSync(folder, { recursive: true, force: true });
});

beforeEach(() => {
  harness = new Harness();
});

afterEach(async () => {
  harness.close();
  await server?.stop();
});

/** Lets a minute pass. This is longer than all pauses, and than three of the slowest retries. */
const waitAMinute = () => passTime(60_000, () => fetch(`${server.target}/healthz`));

async function proxyOf(target: string): Promise<void> {
  server = new FaultProxy(target);
  await server.start();
}

const sources: [string, () => string, () => Source][] = [
  [
    "the server's batches",
    () => isosplat.url,
    () => new ServerSource({ base: server.url, volume: "test" }),
  ],
  ["a static file", () => host.url, () => new FileSource(`${server.url}/test.isosplat`)],
];

describe.each(sources)("from %s", (_, target, source) => {
  beforeEach(() => proxyOf(target()));

  test("a view completes, and every chunk is fetched once", async () => {
    const session = await harness.open(source(), core, { firstIsovalues: [100.5] });
    session.update(view(100.5));
    await harness.complete();
    expect(harness.errors).toEqual([]);
    expect(harness.progress?.finestLevel).toBe(0);
    expect(fetchedTwice(server.requests)).toEqual([]);
    expect([...harness.uploaded.values()].every((times) => times === 1)).toBe(true);
    expect(harness.progress?.bytesFetched).toBe(server.bytesSent);
    expect(harness.progress?.requests).toBe(server.requests.length);
  });

  test("the first surface takes few requests and bytes", async () => {
    const session = await harness.open(source(), core, { firstIsovalues: [100.5] });
    session.update(view(100.5));
    let requests = 0;
    await harness.until(() => {
      if (harness.visible.length > 0) requests ||= server.requests.length;
      return requests > 0;
    });
    expect(requests).toBeLessThanOrEqual(6);
  });

  test("any isovalue has a surface without a request once the coarse tail is resident", async () => {
    const session = await harness.open(source(), core, { firstIsovalues: [100.5] });
    session.update(view(100.5));
    await harness.complete();
    const before = server.requests.length;
    // Moves a slider: each change follows the previous one at once.
    for (let isovalue = -99; isovalue < 500; isovalue += 20) {
      session.update(view(isovalue));
      expect(harness.visible.length).toBeGreaterThan(0);
    }
    expect(server.requests.length - before).toBeLessThanOrEqual(2);
    await harness.complete();
  });

  test("an isovalue within resident bands makes no request", async () => {
    const session = await harness.open(source(), core, { firstIsovalues: [100.5] });
    session.update(view(100.5));
    await harness.complete();
    const before = server.requests.length;
    session.update(view(101.5));
    await harness.complete();
    expect(harness.progress?.finestLevel).toBe(0);
    expect(server.requests.length).toBe(before);
  });

  test("an isovalue beyond the range is complete with nothing to draw", async () => {
    const session = await harness.open(source(), core);
    session.update(view(5000));
    await harness.complete();
    expect(harness.visible).toEqual([]);
    session.update(view(100.5));
    await harness.complete();
    expect(harness.visible.length).toBeGreaterThan(0);
  });

  test("without isovalues, a view is complete with nothing to draw", async () => {
    const session = await harness.open(source(), core);
    session.update(view(100.5));
    await harness.complete();
    const before = server.requests.length;
    session.update({ ...view(100.5), isovalues: [] });
    await harness.complete();
    expect(harness.errors).toEqual([]);
    expect(harness.visible).toEqual([]);
    expect(server.requests.length).toBe(before);
    session.update(view(100.5));
    await harness.complete();
    expect(harness.visible.length).toBeGreaterThan(0);
  });

  test("the budget holds at all times, and limits what is shown", async () => {
    const sampleBudget = 60_000;
    const session = await harness.open(source(), core, { sampleBudget });
    for (const isovalue of [100.5, 300.5, 0.5, 450.5, 100.5]) {
      session.update(view(isovalue));
      await harness.until(
        () =>
          harness.visible.length > 0 && /^(complete|limited)$/.test(harness.progress?.state ?? ""),
      );
      if (isovalue === 100.5) {
        expect(harness.progress?.state).toBe("limited");
        expect(harness.progress?.complete).toBe(false);
      }
    }
    expect(harness.maxResident).toBeLessThanOrEqual(sampleBudget);
    expect(harness.progress?.samplesResident).toBe(harness.samples);
  });

  test("responses that arrive slowly, late and out of order are combined", async () => {
    server.fault = (_path, number) =>
      number % 3 === 0
        ? { kind: "delay", milliseconds: 30 + (number % 5) * 20 }
        : { kind: "drip", bytes: 1000 * (number % 7) + 777 };
    const session = await harness.open(source(), core);
    session.update(view(300.5));
    await harness.complete();
    expect(harness.errors).toEqual([]);
    expect([...harness.uploaded.values()].every((times) => times === 1)).toBe(true);
  });

  test("broken connections and 5xx are retried, without a report if that succeeds", async () => {
    const faults = [
      { kind: "reset" } as const,
      { kind: "status", status: 500 } as const,
      { kind: "truncate", bytes: 30_000 } as const,
      undefined,
    ];
    let seen = 0;
    server.fault = () => faults[seen++ % faults.length];
    const session = await harness.open(source(), core);
    session.update(view(300.5));
    await harness.until(() => harness.progress?.complete === true, 25_000);
    expect(harness.errors.filter(({ retrying }) => !retrying)).toEqual([]);
  });

  test("after 429, requests wait for the time that the server states", async () => {
    const session = await harness.open(source(), core);
    let begunAt = 0;
    const triedAt: number[] = [];
    // All requests in flight at that time are refused.
    server.fault = () => {
      begunAt ||= Date.now();
      if (Date.now() - begunAt < 500) return { kind: "status", status: 429, retryAfter: 1 };
      triedAt.push(Date.now());
      return undefined;
    };
    session.update(view(300.5));
    await harness.complete();
    expect(Math.min(...triedAt) - begunAt).toBeGreaterThan(900);
  });

  test("a server that stops is reported once, and streaming continues when it is back", async () => {
    const session = await harness.open(source(), core);
    session.update(view(100.5));
    await harness.complete();
    await server.stop();
    session.update(view(300.5));
    await harness.until(() => harness.errors.length > 0);
    expect(harness.errors[0]?.kind).toBe("unreachable");
    expect(harness.errors[0]?.retrying).toBe(true);
    expect(harness.progress?.state).toBe("offline");
    expect(harness.visible.length).toBeGreaterThan(0);
    await server.start();
    session.retry();
    await harness.complete();
    expect(harness.errors.length).toBe(1);
  });

  test("a flipped bit is fetched again once", async () => {
    const session = await harness.open(source(), core);
    session.update(view(100.5));
    await harness.complete();
    let corrupted = false;
    server.fault = () => {
      if (corrupted) return undefined;
      corrupted = true;
      return { kind: "corrupt", at: 60 };
    };
    session.update(view(300.5));
    await harness.complete();
    expect(corrupted).toBe(true);
    expect(harness.errors).toEqual([]);
  });

  test("bits that stay flipped are reported, and the coarser level is shown", async () => {
    const session = await harness.open(source(), core);
    session.update(view(100.5));
    await harness.complete();
    server.fault = () => ({ kind: "corrupt", at: 60 });
    session.update(view(300.5));
    await harness.until(() => harness.progress?.state === "incomplete");
    expect(harness.errors.length).toBeGreaterThan(0);
    expect(harness.errors.every(({ kind }) => kind === "damaged-part")).toBe(true);
    expect(harness.progress?.fault?.kind).toBe("damaged-part");
    expect(harness.errors[0]?.message).toMatch(/checksum.*expected 0x.*found 0x/);
    expect(harness.visible.length).toBeGreaterThan(0);
  });

  test("404 is reported, and not retried in a loop", async () => {
    const session = await harness.open(source(), core);
    session.update(view(100.5));
    await harness.complete();
    server.fault = () => ({ kind: "elsewhere", path: "/v1/volumes/none" });
    const before = server.requests.length;
    session.update(view(300.5));
    await harness.until(() => harness.errors.length > 0);
    await waitAMinute();
    expect(harness.errors[0]?.kind).toBe("not-found");
    expect(harness.errors.length).toBe(1);
    expect(harness.progress?.state).toBe("incomplete");
    expect(server.requests.length - before).toBeLessThanOrEqual(6);
    server.fault = () => undefined;
    session.retry();
    await harness.complete();
  });

  test("requests that are no longer needed are cancelled", async () => {
    const session = await harness.open(source(), core);
    session.update(view(100.5));
    await harness.complete();
    server.fault = () => ({ kind: "drip", bytes: 500 });
    const before = server.bytesSent;
    session.update(view(300.5));
    await harness.until(() => server.requests.length > 0 && server.bytesSent > before);
    // From far away, the resident coarse levels suffice.
    session.update(view(300.5, 30));
    await harness.complete();
    const total = server.bytesSent;
    await waitAMinute();
    expect(server.bytesSent - total).toBeLessThan(50_000);
  });

  test("a volume that is closed releases everything, and no event follows", async () => {
    const session = await harness.open(source(), core);
    session.update(view(100.5));
    await harness.until(() => harness.visible.length > 0);
    harness.close();
    expect(harness.resident.size).toBe(0);
    await waitAMinute();
    expect(harness.resident.size).toBe(0);
    session.update(view(300.5));
  });

  test("volumes that are opened one after the other do not accumulate in the core's memory", async () => {
    const openOne = async (): Promise<number> => {
      const each = new Harness();
      const session = await each.open(source(), core);
      session.update(view(100.5));
      await each.complete();
      each.close();
      expect(each.resident.size).toBe(0);
      return core.heapBytes;
    };
    await openOne();
    await openOne();
    const before = await openOne();
    for (let i = 0; i < 3; ++i) await openOne();
    expect(await openOne()).toBe(before);
  });

  test("long use does not grow the core's memory, nor the samples held beyond the budget", async () => {
    const sampleBudget = 120_000;
    const session = await harness.open(source(), core, { sampleBudget });
    const use = async (): Promise<number> => {
      for (let step = 0; step < 8; ++step) {
        session.update(view(-50 + 65 * step, 1.2 + (step % 3)));
        await harness.complete();
      }
      return core.heapBytes;
    };
    await use();
    const before = await use();
    for (let round = 0; round < 2; ++round) await use();
    expect(core.heapBytes).toBe(before);
    expect(harness.maxResident).toBeLessThanOrEqual(sampleBudget);
    expect(harness.errors).toEqual([]);
  }, 60_000);

  test("opening can be aborted, and fails with a message", async () => {
    server.fault = () => ({ kind: "delay", milliseconds: 2000 });
    const ending = new AbortController();
    const opened = harness.open(source(), core, { signal: ending.signal });
    setTimeout(() => ending.abort(new Error("enough")), 50);
    await expect(opened).rejects.toThrow("enough");
    server.fault = () => ({ kind: "elsewhere", path: "/v1/volumes/none" });
    await expect(new Harness().open(source(), core)).rejects.toBeInstanceOf(StreamError);
  });
});
