/** Small stores, read as a whole from the real server while a view is complete. */
import { readFileSync, statSync } from "node:fs";
import { expect, test, vi } from "vitest";
import type { Chunk } from "../../web/core/index.ts";
import { bandDistance } from "../../web/stream/fetch_ahead.ts";
import { ServerSource, type StreamOptions } from "../../web/stream/index.ts";
import { chunksOf } from "../browser/support/chunks.ts";
import { fetchedTwice } from "../support/fault_proxy.ts";
import {
  chunkRequests,
  core,
  harness,
  newHarness,
  serveDemo,
  server,
  store,
} from "./demo_session.ts";
import { parallelView as view } from "./demo_view.ts";
import { passTime } from "./fake_clock.ts";
import { openWhole } from "./fixture.ts";

serveDemo();

/** Opens the volume with all of it read ahead, and waits until a view is complete. */
async function open(options: Partial<StreamOptions> = {}) {
  const source = new ServerSource({ base: server.url, volume: "mandelbulb" });
  const session = await harness.open(source, core, {
    firstIsovalues: [120.5],
    readAheadBytes: 1e9,
    ...options,
  });
  session.update(view(120.5));
  await harness.complete();
  return session;
}

const nameOf = ({ level, block, band }: Chunk): string => `${level}/${block.join(".")}/${band}`;
const isRunning = (): boolean => harness.progress?.preparation != null;
const ended = (): Promise<void> => harness.until(() => !isRunning());
const started = (): Promise<void> => harness.until(isRunning);

test("any isovalue is complete at level 0 without a request", async () => {
  const session = await open();
  const resident = new Set(harness.resident.keys());
  await started();
  expect(harness.progress?.state).toBe("complete");
  expect(harness.progress?.preparation?.bytesPlanned).toBeGreaterThan(1e6);
  await ended();
  expect(new Set(harness.resident.keys()), "chunks stay encoded").toEqual(resident);
  expect(fetchedTwice(server.requests)).toEqual([]);
  const size = statSync(store).size;
  expect(harness.progress?.bytesFetched).toBeGreaterThan(0.95 * size);
  expect(harness.progress?.bytesFetched).toBeLessThan(1.05 * size);

  const before = server.requests.length;
  for (const isovalue of [10.5, 60.5, 200.5, 250.5, 120.5]) {
    session.update(view(isovalue, 256));
    await harness.complete();
    expect(harness.progress?.finestLevel).toBe(harness.visible.length > 0 ? 0 : -1);
  }
  expect(server.requests.length).toBe(before);
  expect(harness.errors).toEqual([]);
});

test("while the isovalue moves, its chunks are decoded without a request", async () => {
  const session = await open();
  await started();
  await ended();
  const before = server.requests.length;
  for (let isovalue = 20.5; isovalue < 240; isovalue += 20) {
    session.update(view(isovalue, 256));
    await vi.advanceTimersByTimeAsync(40);
    await new Promise((resolve) => setImmediate(resolve));
  }
  // This is earlier than the end of a movement.
  await harness.until(() => harness.progress?.complete === true, 150);
  expect(harness.progress?.finestLevel).toBe(0);
  expect(server.requests.length).toBe(before);
});

test("no occlusion query is needed for a view whose chunks are kept", async () => {
  harness.answersOcclusion = true;
  const session = await open();
  await started();
  await ended();
  harness.queries = 0;
  session.update(view(60.5, 256));
  await harness.complete();
  expect(harness.progress?.finestLevel).toBe(0);
  expect(harness.queries).toBe(0);
});

test("not a larger store, not with the data saver on, not with 0", async () => {
  await open({ readAheadBytes: statSync(store).size - 1 });
  await passTime(60_000, () => fetch(`${server.url}/healthz`));
  const complete = chunkRequests().length;
  harness.close();

  newHarness();
  await open({ readAheadBytes: 0 });
  await passTime(60_000, () => fetch(`${server.url}/healthz`));
  expect(chunkRequests().length).toBe(2 * complete);
  harness.close();

  vi.stubGlobal("navigator", { connection: { saveData: true } });
  newHarness();
  await open();
  expect(harness.progress?.preparation).toBeNull();
  await passTime(60_000, () => fetch(`${server.url}/healthz`));
  expect(chunkRequests().length).toBe(3 * complete);
});

test.each([
  ["upwards", 118.5, 1],
  ["downwards", 122.5, -1],
])(
  "the nearest bands come first, and those ahead before those behind: %s",
  async (_, from, direction) => {
    const session = await open();
    session.update(view(from));
    await harness.complete();
    session.update(view(120.5));
    await harness.complete();
    const before = server.requests.length;
    await started();
    await ended();
    const whole = openWhole(core, new Uint8Array(readFileSync(store)));
    const chunks = Array.from({ length: whole.info.levels }, (__, level) =>
      whole.chunksFor(level, 0, 255),
    ).flat();
    const byName = new Map(chunks.map((chunk) => [nameOf(chunk), chunk]));
    const distances = chunksOf(server.requests.slice(before).map(({ path }) => path)).map(
      (name) => {
        const chunk = byName.get(name);
        return chunk ? bandDistance(chunk, 120.5) * direction : Number.NaN;
      },
    );
    const early = distances.slice(0, distances.length / 4);
    const late = distances.slice(-distances.length / 4);
    expect(Math.max(...early)).toBeGreaterThan(1.5 * Math.max(...early.map((each) => -each)));
    expect(Math.max(...early)).toBeLessThan(Math.max(...late.map(Math.abs)));
  },
);

test("a change of the view cancels it, and afterwards it continues", async () => {
  const session = await open();
  server.fault = (path) => (/batch|chunks/.test(path) ? { kind: "silence" } : undefined);
  const before = chunkRequests().length;
  await harness.until(() => chunkRequests().length > before);
  server.fault = () => undefined;
  session.update(view(120.5, 256));
  expect(harness.progress?.preparation).toBeNull();
  await harness.complete();
  await started();
  await ended();
  expect(harness.progress?.bytesFetched).toBeGreaterThan(0.95 * statSync(store).size);
  expect(harness.errors).toEqual([]);
});

test("damaged chunks are fetched again when a view needs them", async () => {
  const session = await open();
  server.fault = (path) => (/batch|chunks/.test(path) ? { kind: "corrupt", at: -5 } : undefined);
  await started();
  await ended();
  expect(harness.progress?.complete).toBe(true);
  expect(harness.errors).toEqual([]);
  server.fault = () => undefined;
  for (const isovalue of [20.5, 60.5, 200.5]) {
    session.update(view(isovalue, 256));
    await harness.complete();
    expect(harness.progress?.finestLevel).toBe(0);
  }
  expect(harness.errors).toEqual([]);
  // The source has returned wrong bytes, so nothing more is read ahead.
  const made = chunkRequests().length;
  await passTime(60_000, () => fetch(`${server.url}/healthz`));
  expect(chunkRequests().length).toBe(made);
});

test("a chunk that stays damaged is requested again, and shown once it is repaired", async () => {
  const session = await open({ readAheadBytes: 1e9 });
  server.fault = (path) => (/batch|chunks/.test(path) ? { kind: "corrupt", at: -5 } : undefined);
  session.update(view(200.5, 256));
  await harness.until(() => harness.progress?.state === "incomplete");
  server.fault = () => undefined;
  await passTime(40_000, () => fetch(`${server.url}/healthz`));
  await harness.complete();
  expect(harness.progress?.damagedParts).toBe(0);
});
