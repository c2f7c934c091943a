/** Coarse levels for other isovalues, fetched from the real server while a view is complete. */
import { readFileSync, statSync } from "node:fs";
import { expect, test, vi } from "vitest";
import type { Chunk } from "../../web/core/index.ts";
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

/** Opens the volume and waits until a view is complete whose cells of level 2 are a pixel large. */
async function open(options: Partial<StreamOptions>) {
  const source = new ServerSource({ base: server.url, volume: "mandelbulb" });
  const session = await harness.open(source, core, { firstIsovalues: [226.5], ...options });
  session.update(view(226.5));
  await harness.complete();
  return session;
}

const ended = (): Promise<void> => harness.until(() => harness.progress?.preparation === null);
const started = (): Promise<void> => harness.until(() => harness.progress?.preparation !== null);
/** Lets a minute pass. Returns the number of requests made in it. */
async function requestsOfAMinute(): Promise<number> {
  const made = () => server.requests.filter(({ path }) => path !== "/healthz").length;
  const before = made();
  await passTime(60_000, () => fetch(`${server.url}/healthz`));
  return made() - before;
}

test("any isovalue is drawn at level 1 without a request", async () => {
  const session = await open({ backgroundBytes: 3e6 });
  const complete = harness.progress;
  await started();
  expect(harness.progress?.state).toBe("complete");
  const drawn = [...harness.visible];
  await ended();
  expect(harness.visible).toEqual(drawn);
  expect(harness.progress?.requests).toBeGreaterThan(complete?.requests ?? 0);
  expect(fetchedTwice(server.requests)).toEqual([]);

  const before = server.requests.length;
  // The view resolves level 1. Coarser levels would be drawn where it is missing.
  const levels = new Set<number>();
  for (let isovalue = 0.5; isovalue < 255; isovalue += 5) {
    session.update(view(isovalue, 128));
    if (harness.visible.length === 0) continue;
    for (const id of harness.visible) levels.add(harness.resident.get(id)?.place.level ?? -1);
  }
  expect(Math.max(...levels)).toBe(1);
  expect(server.requests.length).toBe(before);
  await harness.complete();
  expect(server.requests.length).toBe(before);
  expect(harness.errors).toEqual([]);
});

test("by default, at most 4 MB or 0.3 of the store; nothing with the data saver on", async () => {
  await open({ backgroundBytes: undefined as unknown as number });
  await started();
  const planned = harness.progress?.preparation?.bytesPlanned ?? 0;
  expect(planned).toBeGreaterThan(1e6);
  expect(planned).toBeLessThanOrEqual(Math.min(4e6, 0.3 * statSync(store).size));
  await ended();
  harness.close();

  vi.stubGlobal("navigator", { connection: { saveData: true } });
  newHarness();
  await open({ backgroundBytes: 4e6 });
  expect(harness.progress?.preparation).toBeNull();
  expect(await requestsOfAMinute()).toBe(0);
});

test("keeps its budget: the coarsest level for all isovalues, then the nearest bands", async () => {
  await open({ backgroundBytes: 600_000 });
  const before = harness.progress?.bytesFetched ?? 0;
  await started();
  await ended();
  const bytes = (harness.progress?.bytesFetched ?? 0) - before;
  expect(bytes).toBeGreaterThan(400_000);
  expect(bytes).toBeLessThanOrEqual(600_000 + 20_000); // with the frames of responses
  const fetched = new Set(chunksOf(server.requests.map(({ path }) => path)));
  const whole = openWhole(core, new Uint8Array(readFileSync(store)));
  const isFetched = ({ level, block, band }: Chunk): boolean =>
    fetched.has(`${level}/${block.join(".")}/${band}`);
  expect(whole.chunksFor(2, 0, 255).every(isFetched)).toBe(true);
  const distance = ({ bandBegin, bandEnd }: Chunk): number =>
    Math.max(bandBegin - 226.5, 226.5 - bandEnd, 0);
  const finer = whole.chunksFor(1, 0, 255);
  const near = finer.filter(isFetched).map(distance);
  const far = finer.filter((chunk) => !isFetched(chunk)).map(distance);
  expect(near.length).toBeGreaterThan(0);
  expect(Math.max(...near)).toBeLessThanOrEqual(Math.min(...far));
  expect(await requestsOfAMinute(), "at rest").toBe(0);
});

test("is cancelled by a change of view, and continues afterwards", async () => {
  const session = await open({ backgroundBytes: 3e6 });
  server.fault = (path) => (/batch|chunks/.test(path) ? { kind: "silence" } : undefined);
  const before = chunkRequests().length;
  await harness.until(() => chunkRequests().length > before);
  server.fault = () => undefined;
  session.update(view(226.5, 128));
  expect(harness.progress?.preparation).toBeNull();
  await harness.complete();
  expect(harness.errors).toEqual([]);
  await started();
  await ended();
  expect(harness.progress?.complete).toBe(true);
});

test("takes free memory only, and is the first to be dropped", async () => {
  const sampleBudget = 1_200_000;
  const session = await open({ backgroundBytes: 3e6, sampleBudget });
  const ofView = new Set(harness.visible);
  await started();
  await ended();
  expect(harness.maxResident).toBeLessThanOrEqual(sampleBudget);
  expect(harness.maxResident).toBeGreaterThan(sampleBudget / 2);
  for (const id of ofView) expect(harness.resident.has(id)).toBe(true);
  // Level 0 needs the memory of chunks that no view has used.
  session.update(view(226.5, 512));
  await harness.until(() => /complete|limited/.test(harness.progress?.state ?? ""));
  expect(harness.maxResident).toBeLessThanOrEqual(sampleBudget);
  expect([...harness.resident.values()].some(({ place }) => place.level === 0)).toBe(true);
  expect(harness.errors).toEqual([]);
});

test("damaged chunks are not reported before a view needs them", async () => {
  const session = await open({ backgroundBytes: 3e6 });
  server.fault = (path) => (/batch|chunks/.test(path) ? { kind: "corrupt", at: -5 } : undefined);
  await started();
  await ended();
  expect(harness.progress?.complete).toBe(true);
  expect(harness.progress?.fault).toBeNull();
  expect(harness.errors).toEqual([]);
  // Chunks that were damaged are fetched again when a view needs them.
  server.fault = () => undefined;
  for (const isovalue of [20.5, 120.5, 200.5]) {
    session.update(view(isovalue, 128));
    await harness.complete();
  }
  expect(harness.errors).toEqual([]);
});

test("a failing source is not reported, and gets no further request at rest", async () => {
  await open({ backgroundBytes: 3e6 });
  server.fault = (path) =>
    /batch|chunks/.test(path) ? { kind: "status", status: 503 } : undefined;
  await started();
  await ended();
  expect(await requestsOfAMinute()).toBe(0);
  expect(harness.progress?.complete).toBe(true);
  expect(harness.errors).toEqual([]);
});
