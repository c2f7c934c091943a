import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { afterAll, afterEach, beforeAll, expect, test } from "vitest";
import type { Core } from "../../web/core/index.ts";
import { FileSource, ServerSource, type Source, StreamError } from "../../web/stream/index.ts";
import { fieldShare } from "../../web/viewer/time_cost.ts";
import { type RunningServer, serve } from "../browser/support/server.ts";
import { hasPressure, pressure, writeFieldStore } from "../support/field_volumes.ts";
import { type RangeHost, rangeHost } from "../support/range_host.ts";
import { core as load } from "./fixture.ts";
import { Harness } from "./stream_harness.ts";

const folder = mkdtempSync(join(tmpdir(), "isosplat-fields-"));
const missing = 65_535;

let core: Core;
let isosplat: RunningServer;
let host: RangeHost;
let harness = new Harness();

beforeAll(async () => {
  const store = writeFieldStore(folder);
  core = await load();
  isosplat = await serve([store]);
  const file = readFileSync(store);
  host = await rangeHost((path) => (path === "/ball.isosplat" ? file : undefined));
});

afterEach(() => {
  harness.close();
  harness = new Harness();
});

afterAll(async () => {
  host?.stop();
  await isosplat?.stop();
  rmSync(folder, { recursive: true, force: true });
});

const sources: [string, () => Source][] = [
  ["a server", () => new ServerSource({ base: isosplat.url, volume: "ball" })],
  ["a static file", () => new FileSource(`${host.origin}/ball.isosplat`)],
];

/** A static file whose host answers requests for the field late, or not at all. */
class GatedSource extends FileSource {
  gate: "open" | "closed" | "broken" = "open";

  override async range(
    ...[offset, bytes, signal, arrived]: Parameters<FileSource["range"]>
  ): Promise<void> {
    const [field] = harness.session?.info.fields ?? [];
    const isOfField = field && offset >= field.offset && offset < field.offset + field.bytes;
    while (isOfField && this.gate === "closed") {
      signal.throwIfAborted();
      await new Promise((resolve) => setTimeout(resolve, 5));
    }
    if (isOfField && this.gate === "broken") throw new StreamError("unreachable", "no answer");
    await super.range(offset, bytes, signal, arrived);
  }
}

/** The ball from the front, as large as the picture. */
function view(isovalue: number, size: number) {
  const focal = 1 / Math.tan(Math.PI / 8);
  const [near, far, away] = [1, 5000, 200];
  const depth = (far + near) / (far - near);
  const y0 = 65 - away;
  return {
    viewProjection: [
      ...[focal, 0, 0, 0],
      ...[0, 0, depth, 1],
      ...[0, focal, 0, 0],
      ...[-focal * 75, -focal * 35, -depth * y0 - (2 * far * near) / (far - near), -y0],
    ],
    viewport: { width: size, height: size },
    isovalues: [isovalue],
    moving: false,
  };
}

/** Compares the values of all drawn chunks of level 0 with the field. Returns the number of corners. */
function compareWithField(): number {
  const { mapping } = harness.session?.info.fields[0] ?? { mapping: undefined };
  if (!mapping) throw new Error("the store has no field");
  let corners = 0;
  for (const id of harness.visible) {
    const { level, block } = harness.resident.get(id)?.place ?? { level: 1, block: [0, 0, 0] };
    const samples = harness.samplesOf.get(id) as Uint32Array;
    const values = harness.values.get(id) as Uint32Array;
    expect(values.length).toBe(samples.length);
    if (level > 0) continue;
    for (let i = 0; i < samples.length; i += 4) {
      const cell = samples[i] as number;
      for (let c = 0; c < 8; ++c, ++corners) {
        const x = 64 * block[0] + (cell & 63) + (c & 1);
        const y = 64 * block[1] + ((cell >> 6) & 63) + ((c >> 1) & 1);
        const z = 64 * block[2] + ((cell >> 12) & 63) + (c >> 2);
        const found = ((values[i + (c >> 1)] as number) >>> (16 * (c & 1))) & 0xffff;
        const isExpected = hasPressure(x, y)
          ? Math.abs(mapping.offset + mapping.scale * found - pressure(x, y, z)) <=
            mapping.maxError * 1.001
          : found === missing;
        if (!isExpected) throw new Error(`voxel ${x} ${y} ${z}: found ${found}`);
      }
    }
  }
  return corners;
}

const hasValues = (): boolean => harness.visible.every((id) => harness.values.has(id));

test.each(sources)("the values of a field come with the chunks of %s", async (_, source) => {
  const session = await harness.open(source(), core);
  expect(session.info.fields).toMatchObject([{ name: "pressure", mapping: { hasMissing: true } }]);
  expect(() => session.showField("temperature")).toThrow(RangeError);
  session.showField("pressure");
  session.update(view(100.5, 1600));
  await harness.until(() => harness.progress?.complete === true);
  expect(hasValues()).toBe(true);
  expect(compareWithField()).toBeGreaterThan(50_000);
});

test.each(sources)("a field of %s can be shown and hidden later", async (_, source) => {
  const session = await harness.open(source(), core);
  session.update(view(100.5, 1600));
  await harness.until(() => harness.progress?.complete === true);
  expect(harness.values.size).toBe(0);
  const { bytesFetched, samplesResident } = harness.progress ?? {};
  session.showField("pressure");
  await harness.until(() => harness.progress?.complete === true && hasValues());
  expect(compareWithField()).toBeGreaterThan(50_000);
  expect(harness.progress?.samplesResident).toBe(samplesResident);
  expect(harness.progress?.bytesFetched).toBeGreaterThan(bytesFetched ?? 0);
  // Another isovalue: its chunks come with their values.
  session.update(view(60.5, 1600));
  await harness.until(() => harness.progress?.complete === true && hasValues());
  expect(compareWithField()).toBeGreaterThan(10_000);
  session.showField(null);
  harness.values.clear();
  session.update(view(140.5, 1600));
  await harness.until(() => harness.progress?.complete === true);
  expect(harness.values.size).toBe(0);
});

test.each(sources)(
  "a distant view of %s has the values of the coarsest levels",
  async (_, source) => {
    const session = await harness.open(source(), core);
    session.showField("pressure");
    session.update(view(100.5, 5));
    await harness.until(() => harness.progress?.complete === true && hasValues());
    expect(harness.progress?.finestLevel).toBe(session.info.levels - 1);
    expect(harness.progress?.damagedParts).toBe(0);
  },
);

test.each([
  ["chunks", 32 * 1024],
  ["header", 100],
])("a surface is drawn without the values of a field whose %s are damaged", async (_, from) => {
  const file = new Uint8Array(readFileSync(join(folder, "ball.isosplat")));
  const [field] = (await harness.open(sources[1]?.[1]() as Source, core)).info.fields;
  if (!field) throw new Error("the store has no field");
  harness.close();
  // The header, and then the chunks of the finest level, come first.
  file.fill(0xaa, field.offset + from, field.offset + field.bytes / 2);
  const damaged = await rangeHost(() => file);
  try {
    harness = new Harness();
    const session = await harness.open(new FileSource(`${damaged.origin}/ball.isosplat`), core);
    session.showField("pressure");
    session.update(view(100.5, 1600));
    await harness.until(() => harness.progress?.state === "incomplete");
    expect(harness.progress?.damagedParts).toBeGreaterThan(0);
    expect(harness.progress?.fault?.kind).toBe("damaged-part");
    expect(harness.progress?.finestLevel).toBe(0);
    expect(hasValues()).toBe(false);
    session.showField(null);
    await harness.until(() => harness.progress?.complete === true);
  } finally {
    damaged.stop();
  }
});

test("chunks of an earlier view do not wait for the field, nor delay the present one", async () => {
  const source = new GatedSource(`${host.origin}/ball.isosplat`);
  const session = await harness.open(source, core);
  session.showField("pressure");
  session.update(view(100.5, 1600));
  await harness.until(() => harness.progress?.complete === true && hasValues());
  source.gate = "closed";
  const before = harness.resident.size;
  session.update(view(60.5, 1600));
  await harness.until(() => (harness.progress?.chunksToGo ?? 0) > 0 && !session.isClosed);
  // Time for the store's chunks, which are held.
  await new Promise((resolve) => setTimeout(resolve, 500));
  session.update(view(140.5, 1600));
  await harness.until(() => harness.resident.size > before);
  source.gate = "open";
  await harness.until(() => harness.progress?.complete === true && hasValues());
  expect(harness.progress?.chunksToGo).toBe(0);
  expect(compareWithField()).toBeGreaterThan(10_000);
});

test("surfaces are complete without a field that cannot be fetched, until it can", async () => {
  const source = new GatedSource(`${host.origin}/ball.isosplat`);
  const session = await harness.open(source, core);
  session.showField("pressure");
  session.update(view(100.5, 1600));
  await harness.until(() => harness.progress?.complete === true && hasValues());
  source.gate = "broken";
  session.update(view(60.5, 1600));
  await harness.until(() => harness.progress?.fault?.kind === "unreachable");
  await harness.until(() => harness.progress?.finestLevel === 0);
  expect(hasValues()).toBe(false);
  source.gate = "open";
  session.retry();
  await harness.until(() => harness.progress?.complete === true && hasValues());
  expect(harness.progress?.fault).toBeNull();
});

test("values that do not fit into memory leave the surface as it is", async () => {
  const session = await harness.open(sources[1]?.[1]() as Source, core, { sampleBudget: 4e6 });
  session.update(view(100.5, 1600));
  await harness.until(() => harness.progress?.complete === true);
  expect(harness.progress?.sampleBudget).toBe(4e6);
  session.showField("pressure");
  // The values take as much memory as the samples.
  await harness.until(() => harness.progress?.sampleBudget === 2e6);
  await harness.until(() => harness.progress?.complete === true && hasValues());
  const { visible } = harness;
  harness.values.clear();
  session.rejectFieldValues(visible, "no room");
  await harness.until(() => harness.progress?.fault?.kind === "out-of-memory");
  await new Promise((resolve) => setTimeout(resolve, 100));
  expect(harness.visible).toEqual(visible);
  expect(harness.values.size).toBe(0);
  session.retry();
  await harness.until(() => harness.progress?.complete === true && hasValues());
  expect(harness.progress?.fault).toBeNull();
  session.showField(null);
  await harness.until(() => harness.progress?.sampleBudget === 4e6);
});

test("nothing of a field is fetched while none is shown", async () => {
  const fetched = async (isShown: boolean): Promise<number> => {
    const one = new Harness();
    const session = await one.open(new FileSource(`${host.origin}/ball.isosplat`), core);
    if (isShown) session.showField("pressure");
    session.update(view(100.5, 1600));
    await one.until(() => one.progress?.complete === true);
    one.close();
    return one.progress?.bytesFetched ?? 0;
  };
  const without = await fetched(false);
  const { fields } = await harness.open(sources[1]?.[1]() as Source, core).then(({ info }) => info);
  expect(await fetched(true)).toBeGreaterThan(without);
  expect(without).toBeLessThan((harness.session?.info.fileBytes ?? 0) - (fields[0]?.bytes ?? 0));
});

/** A static file whose host answers the header of the field only when the end of the field has been requested. */
class TailFirst extends FileSource {
  readonly ofField: [offset: number, bytes: number][] = [];
  failsTail = false;
  #tailRequested = () => {};
  readonly #tail = new Promise<void>((resolve) => {
    this.#tailRequested = resolve;
  });

  override async range(
    ...[offset, bytes, signal, arrived]: Parameters<FileSource["range"]>
  ): Promise<void> {
    const [field] = harness.session?.info.fields ?? [];
    const end = field ? field.offset + field.bytes : 0;
    if (field && offset >= field.offset && offset < end) this.ofField.push([offset, bytes]);
    if (field && offset === field.offset && this.ofField.length === 1) await this.#tail;
    if (field && offset + bytes === end && this.ofField.length === 2) {
      this.#tailRequested();
      if (this.failsTail) throw new StreamError("unreachable", "no answer");
    }
    await super.range(offset, bytes, signal, arrived);
  }
}

test.each([false, true])(
  "the pages of a field are requested with its header; fails: %s",
  async (failsTail) => {
    const source = new TailFirst(`${host.origin}/ball.isosplat`);
    source.failsTail = failsTail;
    const session = await harness.open(source, core);
    const [field] = session.info.fields;
    if (!field) throw new Error("expected a store with a field, found none");
    session.showField("pressure");
    session.update(view(100.5, 1600));
    await harness.until(() => harness.progress?.complete === true);
    const end = field.offset + field.bytes;
    const tail = Math.max(end - 64 * 1024, field.offset);
    const [header, ...others] = source.ofField;
    expect(header).toEqual([field.offset, Math.min(8 * 1024, field.bytes)]);
    expect(others[0]).toEqual([tail, end - tail]);
    const again = others.slice(1).filter(([offset]) => offset >= tail);
    expect(again.length > 0).toBe(failsTail);
    // The costs of time steps estimate the bytes of the field by its share of the file.
    const share = fieldShare(session.info, field);
    expect(share).toBeGreaterThan(0.05);
    expect(share).toBeLessThan(5);
  },
);
