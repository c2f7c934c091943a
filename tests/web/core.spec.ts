import { readFileSync } from "node:fs";
import { fileURLToPath } from "node:url";
import { afterEach, beforeAll, expect, test } from "vitest";
import { Calls } from "../../web/core/calls.ts";
import {
  type Chunk,
  type Core,
  CoreError,
  type CoreModule,
  maxHeaderBytes,
  regionWords,
  type Store,
} from "../../web/core/index.ts";
import {
  countActive,
  core as load,
  offset,
  openWhole,
  quantized,
  storeBytes,
  voxels,
} from "./fixture.ts";

let core: Core;
let file: Uint8Array;
const open: Store[] = [];

beforeAll(async () => {
  core = await load();
  file = storeBytes();
});

afterEach(() => {
  for (const store of open.splice(0)) store.close();
});

function whole(): Store {
  const store = openWhole(core, file);
  open.push(store);
  return store;
}

function bytesOf(chunk: Chunk): Uint8Array {
  return file.subarray(chunk.offset, chunk.offset + chunk.bytes);
}

test("the header describes the volume", () => {
  const { info } = whole();
  expect(info.voxels).toEqual(voxels);
  expect(info.spacing).toEqual([1, 1, 1.5]);
  expect(info.origin).toEqual([-10, 20, 30]);
  expect(info.mapping).toEqual({
    offset,
    scale: 1,
    maxError: 0,
    bits: 16,
    hasMissing: false,
  });
  expect(info.fileBytes).toBe(file.length);
  expect(info.contentId).toMatch(/^[0-9a-f]{32}$/);
  expect(info.metadata.name).toBe("test");
  expect(info.levels).toBe(5);
});

test("a given spacing replaces that of the header", () => {
  const store = whole();
  const stated = store.info.spacing;
  store.setSpacing([7, 7, 7]);
  store.setSpacing([0.5, 0.25, 2]);
  expect(store.info.spacing).toEqual([0.5, 0.25, 2]);
  expect(store.info.isSpacingGiven).toBe(true);
  expect(store.info.statedSpacing).toEqual(stated);
  expect(store.info.voxels).toEqual(voxels);
  for (const wrong of [0, -1, Number.NaN, Number.POSITIVE_INFINITY]) {
    expect(() => store.setSpacing([1, wrong, 1])).toThrow("three numbers above 0");
  }
  expect(store.info.spacing).toEqual([0.5, 0.25, 2]);
});

test("pages that are missing are named, and chunks need them", () => {
  const store = core.openStore(file.subarray(0, maxHeaderBytes));
  open.push(store);
  const missing = store.missingPages(0, 100.5);
  expect(missing.length).toBeGreaterThan(0);
  expect(() => store.chunksFor(0, 100.5)).toThrow(
    expect.objectContaining({ status: "page_not_resident" }),
  );
  for (const index of missing) {
    const page = store.pages()[index];
    if (!page) throw new Error("no such page");
    store.addPage(index, file.subarray(page.offset, page.offset + page.bytes));
  }
  expect(store.missingPages(0, 100.5)).toEqual([]);
  expect(store.chunksFor(0, 100.5).length).toBeGreaterThan(0);
});

test("the chunks of an isovalue hold exactly its active cells, once each", () => {
  const store = whole();
  for (const isovalue of [-100, -99.5, 0, 100.5, 420.25, 506, 1000]) {
    const quantizedIsovalue = isovalue - offset;
    const active = new Set<number>();
    let repeated = 0;
    for (const chunk of store.chunksFor(0, isovalue)) {
      const samples = store.decodeSamples(chunk, bytesOf(chunk));
      const packed = store.decodePacked(chunk, bytesOf(chunk));
      expect(samples.count).toBe(chunk.cells);
      expect(packed.length).toBe(4 * chunk.cells);
      for (let i = 0; i < samples.count; ++i) {
        const low = (samples.intervals[2 * i] ?? 0) - offset;
        const high = (samples.intervals[2 * i + 1] ?? 0) - offset;
        if (!(low <= quantizedIsovalue && quantizedIsovalue < high)) continue;
        const [x, y, z] = cellOf(samples.positions, i);
        const cell = (z * voxels[1] + y) * voxels[0] + x;
        if (active.has(cell)) ++repeated;
        active.add(cell);
      }
    }
    expect(repeated).toBe(0);
    expect(active.size).toBe(countActive(quantizedIsovalue));
  }
});

/** The cell of a sample at its centre. */
function cellOf(positions: Float32Array, i: number): [number, number, number] {
  const at = (axis: number): number => positions[3 * i + axis] ?? 0;
  return [
    Math.round(at(0) + 10 - 0.5),
    Math.round(at(1) - 20 - 0.5),
    Math.round((at(2) - 30) / 1.5 - 0.5),
  ];
}

test("samples have the trilinear value and gradient at the cell's centre", () => {
  const store = whole();
  const [chunk] = store.chunksFor(0, 200.5);
  if (!chunk) throw new Error("no chunk");
  const samples = store.decodeSamples(chunk, bytesOf(chunk));
  for (let i = 0; i < samples.count; i += 97) {
    const [x, y, z] = cellOf(samples.positions, i);
    const corner = (c: number): number =>
      quantized(x + (c & 1), y + ((c >> 1) & 1), z + (c >> 2)) + offset;
    const sum = (weight: (c: number) => number): number =>
      [0, 1, 2, 3, 4, 5, 6, 7].reduce((total, c) => total + weight(c) * corner(c), 0);
    expect(samples.values[i]).toBeCloseTo(
      sum(() => 1 / 8),
      3,
    );
    for (const axis of [0, 1, 2]) {
      const slope = sum((c) => ((c >> axis) & 1 ? 1 : -1) / 4) / (axis === 2 ? 1.5 : 1);
      expect(samples.gradients[3 * i + axis]).toBeCloseTo(slope, 3);
    }
  }
});

test("exactly projected points lie on the trilinear surface", () => {
  const store = whole();
  const isovalue = 310.5;
  const [chunk] = store.chunksFor(0, isovalue);
  if (!chunk) throw new Error("no chunk");
  const exact = store.project(chunk, bytesOf(chunk), isovalue, { exact: true });
  const newton = store.project(chunk, bytesOf(chunk), isovalue);
  expect(exact.count).toBeGreaterThan(100);
  expect(newton.count).toBeGreaterThan(100);
  let onSurface = 0;
  for (let i = 0; i < exact.count; ++i) {
    const [px = 0, py = 0, pz = 0] = exact.positions.subarray(3 * i, 3 * i + 3);
    if (Math.abs(trilinear(px + 10, py - 20, (pz - 30) / 1.5) + offset - isovalue) < 0.05) {
      ++onSurface;
    }
    const [nx = 0, ny = 0, nz = 0] = exact.normals.subarray(3 * i, 3 * i + 3);
    expect(Math.hypot(nx, ny, nz)).toBeCloseTo(1, 4);
  }
  // The other samples' rays along the gradient leave the cell before they meet the surface.
  expect(onSurface / exact.count).toBeGreaterThan(0.7);
});

test("packed samples project to the same points, and region by region", () => {
  const store = whole();
  const isovalue = 60.5;
  const [chunk] = store.chunksFor(0, isovalue);
  if (!chunk) throw new Error("no chunk");
  const packed = store.decodePacked(chunk, bytesOf(chunk));
  // No cell spans 512 quantized values, so packing loses nothing.
  for (const exact of [false, true]) {
    const expected = store.project(chunk, bytesOf(chunk), isovalue, { exact });
    expect(expected.count).toBeGreaterThan(100);
    expect(store.projectPacked(chunk, packed, isovalue, { exact })).toEqual(expected);
  }
  // The lower half of each slice, and the rest.
  const lower = Uint32Array.from({ length: regionWords }, (_, i) => (i % 2 === 0 ? ~0 : 0));
  const upper = lower.map((word) => ~word);
  const parts = [lower, upper].map((regions) =>
    store.projectPacked(chunk, packed, isovalue, { regions }),
  );
  const all = store.projectPacked(chunk, packed, isovalue);
  expect(parts.map(({ count }) => count > 0)).toEqual([true, true]);
  expect(parts.reduce((sum, { count }) => sum + count, 0)).toBe(all.count);
  // Regions of the lower half have y below 32 cells.
  const highest = (points: Float32Array): number =>
    points.reduce((most, y, i) => (i % 3 === 1 ? Math.max(most, y) : most), -Infinity);
  const middle = 20 + 64 * chunk.block[1] + 32;
  expect(highest(parts[0]?.positions ?? all.positions)).toBeLessThanOrEqual(middle);
  expect(() => store.projectPacked({ level: 9, block: [0, 0, 0] }, packed, 0)).toThrow(
    "level 9 does not exist",
  );
});

function trilinear(x: number, y: number, z: number): number {
  const [i, j, k] = [Math.floor(x), Math.floor(y), Math.floor(z)];
  const f = [x - i, y - j, z - k];
  let value = 0;
  for (let c = 0; c < 8; ++c) {
    const weight = f.reduce((w, v, axis) => w * ((c >> axis) & 1 ? v : 1 - v), 1);
    value += weight * quantized(i + (c & 1), j + ((c >> 1) & 1), k + (c >> 2));
  }
  return value;
}

test("errors have the status' name and state what was expected", () => {
  const failure = (run: () => unknown): CoreError => {
    try {
      run();
    } catch (error) {
      if (error instanceof CoreError) return error;
    }
    throw new Error("expected a CoreError");
  };
  expect(failure(() => core.openStore(new Uint8Array(100))).status).toBe("not_a_store");
  expect(failure(() => core.openStore(file.subarray(0, 40))).status).toBe("truncated");
  const flipped = file.slice(0, maxHeaderBytes);
  flipped[60] = (flipped[60] ?? 0) ^ 1;
  expect(failure(() => core.openStore(flipped)).status).toBe("checksum_mismatch");
  const store = whole();
  expect(failure(() => store.chunksFor(9, 0)).status).toBe("not_found");
  expect(failure(() => store.setResident(1e6, true)).status).toBe("not_found");
  const [chunk] = store.chunksFor(1, 100.5);
  if (!chunk) throw new Error("no chunk");
  const short = bytesOf(chunk).subarray(0, 10);
  const error = failure(() => store.decodePacked(chunk, short));
  expect(["truncated", "malformed_chunk"]).toContain(error.status);
  expect(error.message.length).toBeGreaterThan(20);
});

test("a chunk's checksum equals that in the directory", () => {
  const store = whole();
  for (const chunk of store.chunksFor(2, 100.5)) {
    expect(core.checksum(bytesOf(chunk))).toBe(chunk.checksum);
  }
});

test("a chunk decodes to the same samples, sorted by region, with a cluster for each region", () => {
  const store = whole();
  for (const chunk of store.chunksFor(1, 100.5)) {
    const { samples, clusters } = core.decodeChunk(chunk, bytesOf(chunk));
    // A region has 8³ cells: its index has the upper three of each coordinate's six bits
    // (packed_sample.h).
    const regionOf = (sample: readonly number[]): number => {
      const [cell = 0] = sample;
      return ((cell >> 3) & 7) | (((cell >> 9) & 7) << 3) | (((cell >> 15) & 7) << 6);
    };
    const split = (words: Uint32Array): number[][] =>
      Array.from({ length: words.length / 4 }, (_, i) => [...words.subarray(4 * i, 4 * i + 4)]);
    const stored = split(store.decodePacked(chunk, bytesOf(chunk)));
    // A stable sort: within a region the order is that of the chunk.
    const sorted = stored.toSorted((x, y) => regionOf(x) - regionOf(y));
    // At coarse levels the samples for the renderer have neighbour bits.
    const drawn = split(samples);
    expect(drawn.some(([cell = 0]) => (cell & ~0x3fc3ffff) !== 0)).toBe(true);
    expect(drawn.map(([cell = 0, ...rest]) => [cell & 0x3fc3ffff, ...rest])).toEqual(sorted);
    const regions = new Set(sorted.map(regionOf));
    expect(clusters.length % regions.size).toBe(0);
    const size = clusters.length / regions.size;
    const words = new DataView(clusters.buffer);
    let first = 0;
    [...regions].forEach((region, i) => {
      expect(words.getUint32(size * i, true)).toBe(first);
      const count = words.getUint32(size * i + 4, true);
      expect(count).toBe(sorted.filter((sample) => regionOf(sample) === region).length);
      expect(words.getUint16(size * i + 12, true)).toBe(region);
      first += count;
    });
    expect(first).toBe(chunk.cells);
  }
});

test("a chunk whose bytes were changed is refused with both checksums", () => {
  const store = whole();
  const [chunk] = store.chunksFor(1, 100.5);
  if (!chunk) throw new Error("no chunk");
  const changed = bytesOf(chunk).slice();
  changed[5] = (changed[5] ?? 0) ^ 16;
  const hex = (word: number): string => `0x${word.toString(16).padStart(8, "0")}`;
  const [expected, found] = [hex(chunk.checksum), hex(core.checksum(changed))];
  expect(() => core.decodeChunk(chunk, changed)).toThrow(
    `checksum differs (expected ${expected}, found ${found})`,
  );
});

test("a closed store reports that it is closed", () => {
  const store = openWhole(core, file);
  store.close();
  const closed = "the store has been closed";
  expect(() => store.quantizedIsovalue(100.5)).toThrow(closed);
  expect(() => store.pages()).toThrow(closed);
  expect(() => store.chunksFor(0, 100.5)).toThrow(closed);
  expect(() => store.close()).not.toThrow();
});

test("the module refuses a query of values without a store", async () => {
  const { default: createModule } = await import("../../build/wasm/web/isosplat-core.js");
  const wasmBinary = readFileSync(
    fileURLToPath(new URL("../../build/wasm/web/isosplat-core.wasm", import.meta.url)),
  );
  const module = (await createModule({ wasmBinary })) as CoreModule;
  const calls = new Calls(module);
  expect(() => calls.check(module._isosplat_core_quantized_isovalue(calls.core, 100.5))).toThrow(
    "no store is open",
  );
  calls.close();
});

test("closed stores free their memory", () => {
  const openAndClose = (): number => {
    const store = openWhole(core, file);
    for (const chunk of store.chunksFor(1, 100.5)) store.decodeSamples(chunk, bytesOf(chunk));
    store.close();
    return core.heapBytes;
  };
  for (let i = 0; i < 3; ++i) openAndClose();
  const before = openAndClose();
  for (let i = 0; i < 50; ++i) openAndClose();
  expect(openAndClose()).toBe(before);
});
