/** Kept bytes of stores: a store that is opened again makes no requests. */
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { afterAll, beforeAll, describe, expect, test } from "vitest";
import type { Core } from "../../web/core/index.ts";
import { KeptBytes } from "../../web/stream/kept_bytes.ts";
import { KeptSource } from "../../web/stream/kept_source.ts";
import { ServerSource } from "../../web/stream/server_source.ts";
import { type RunningServer, serve } from "../browser/support/server.ts";
import { core as load, storeBytes } from "./fixture.ts";
import { Harness, view } from "./stream_harness.ts";

describe("kept bytes", () => {
  const bytes = (length: number, first = 0) => Uint8Array.from({ length }, (_, i) => first + i);
  const [a, b] = [{}, {}];

  test("are copies of ranges within one part", () => {
    const kept = new KeptBytes(1000);
    const own = bytes(10, 5);
    kept.keep(a, 100, own);
    own.fill(0);
    expect(kept.take(a, 102, 3)).toEqual(Uint8Array.of(7, 8, 9));
    kept.take(a, 102, 3)?.fill(0);
    expect(kept.take(a, 100, 10)).toEqual(bytes(10, 5));
    expect(kept.take(a, 99, 3)).toBeUndefined();
    expect(kept.take(a, 108, 3)).toBeUndefined();
    expect(kept.take(b, 100, 3)).toBeUndefined();
  });

  test("stay within their limit: the least recently used are dropped first", () => {
    const kept = new KeptBytes(30);
    for (let i = 0; i < 3; ++i) kept.keep(a, 100 * i, bytes(10, i));
    kept.take(a, 0, 1);
    kept.keep(b, 0, bytes(10));
    expect(kept.bytes).toBe(30);
    expect([0, 100, 200].map((at) => kept.take(a, at, 1) !== undefined)).toEqual([
      true,
      false,
      true,
    ]);
    kept.keep(b, 100, bytes(31));
    expect(kept.bytes).toBe(30);
    kept.keep(b, 0, bytes(10));
    expect(kept.bytes).toBe(30);
  });

  test("are forgotten with their owner", () => {
    const kept = new KeptBytes(100);
    kept.keep(a, 0, bytes(10));
    kept.keep(b, 0, bytes(10));
    kept.forget(a);
    expect([kept.bytes, kept.take(a, 0, 1)]).toEqual([10, undefined]);
    kept.clear();
    expect([kept.bytes, kept.take(b, 0, 1)]).toEqual([0, undefined]);
  });
});

describe("a source whose bytes are kept", () => {
  let folder: string;
  let server: RunningServer;
  let core: Core;
  beforeAll(async () => {
    core = await load();
    folder = mkdtempSync(join(tmpdir(), "isosplat-kept-"));
    writeFileSync(join(folder, "test.isosplat"), storeBytes());
    server = await serve([folder]);
  });
  afterAll(async () => {
    await server?.stop();
    rmSync(folder, { recursive: true, force: true });
  });

  const complete = async (source: KeptSource) => {
    const harness = new Harness();
    const options = { firstIsovalues: [100.5], coarseBytes: 0 };
    const session = await harness.open(source, core, options);
    session.update({ ...view(100.5), stepCellPixels: 1 });
    await harness.complete();
    expect(harness.errors).toEqual([]);
    const resident = [...harness.resident.keys()].sort();
    harness.close();
    return resident;
  };

  test("is opened again without a request, and gives the same chunks", async () => {
    const kept = new KeptBytes(64e6);
    const source = new KeptSource(new ServerSource({ base: server.url, volume: "test" }), kept);
    const first = await complete(source);
    const { requests, bytesReceived } = source;
    expect(kept.bytes).toBeLessThanOrEqual(bytesReceived);
    expect(await complete(source)).toEqual(first);
    expect([source.requests, source.bytesReceived]).toEqual([requests, bytesReceived]);
  });

  test("requests bytes again that were dropped, or are wrong", async () => {
    const kept = new KeptBytes(64e6);
    const source = new KeptSource(new ServerSource({ base: server.url, volume: "test" }), kept);
    const first = await complete(source);
    const before = source.bytesReceived;
    source.bypassCaches();
    expect(kept.bytes).toBe(0);
    expect(await complete(source)).toEqual(first);
    expect(source.bytesReceived).toBeGreaterThan(1.5 * before);
    const small = new KeptSource(
      new ServerSource({ base: server.url, volume: "test" }),
      new KeptBytes(20_000),
    );
    await complete(small);
    const some = small.bytesReceived;
    expect(await complete(small)).toEqual(first);
    expect(small.bytesReceived).toBeGreaterThan(some);
  });

  test("of a store that is too large to be kept has the coarse levels for another session", async () => {
    const source = new ServerSource({ base: server.url, volume: "test" });
    const harness = new Harness();
    const session = await harness.open(source, core, {
      firstIsovalues: [100.5],
      readAheadBytes: 1,
    });
    session.update(view(100.5));
    await harness.complete();
    const { bytesReceived } = source;
    // Chunks are not kept. The cells of this view are coarser than those of any level.
    const other = new Harness();
    const options = { firstIsovalues: [100.5], readAheadBytes: 0, backgroundBytes: 0 };
    const again = await other.open(session.source, core, options);
    again.update({ ...view(100.5), stepCellPixels: 1e6 });
    await other.complete();
    expect(other.visible.length).toBeGreaterThan(0);
    // The header alone.
    expect(source.bytesReceived - bytesReceived).toBeLessThan(16 * 1024);
    again.update({ ...view(100.5), stepCellPixels: 1 });
    const fetched = source.requests;
    await other.complete();
    expect(source.requests).toBeGreaterThan(fetched);
    harness.close();
    other.close();
  });

  test("of a step that is shown later fetches only the levels that are requested", async () => {
    const fetched = async (stepCellPixels: number) => {
      const harness = new Harness();
      const source = new ServerSource({ base: server.url, volume: "test" });
      const options = { firstIsovalues: [100.5], coarseBytes: 0 };
      const session = await harness.open(source, core, options);
      session.update({ ...view(100.5), stepCellPixels });
      await harness.complete();
      expect(harness.visible.length).toBeGreaterThan(0);
      const { requests } = source;
      harness.close();
      return { requests, samples: harness.maxResident };
    };
    const [fine, coarse, none] = [
      await fetched(1),
      await fetched(64),
      await fetched(Number.POSITIVE_INFINITY),
    ];
    expect([fine.requests, coarse.requests, none.requests]).toEqual([2, 2, 1]);
    expect(fine.samples).toBeGreaterThan(coarse.samples);
    expect(coarse.samples).toBeGreaterThan(none.samples);
  });
});
