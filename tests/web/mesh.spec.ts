/**
 * Writes surfaces as files in Node. The bytes must equal those that the program writes from the
 * same store.
 */
import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { afterAll, beforeAll, describe, expect, test } from "vitest";
import { CoreError, type StoreInfo } from "../../web/core/index.ts";
import { forecastOf } from "../../web/mesh/forecast.ts";
import {
  forecastSurface,
  meshFormats,
  type SaveSurfaceOptions,
  SurfaceReader,
  saveSurface,
  surfaceExtent,
} from "../../web/mesh/index.ts";
import { hasHoles } from "../../web/mesh/save_surface.ts";
import { BlobSource } from "../../web/stream/index.ts";
import { storeBytes, voxels } from "./fixture.ts";

const isosplat = fileURLToPath(new URL("../../build/release/native/cli/isosplat", import.meta.url));
const folder = mkdtempSync(join(tmpdir(), "isosplat-mesh-"));
const store = join(folder, "fixture.isosplat");
const isovalue = 200.5;
let bytes: Uint8Array;

beforeAll(() => {
  bytes = storeBytes();
  writeFileSync(store, bytes);
});
afterAll(() => rmSync(folder, { recursive: true, force: true }));

const source = (content = bytes) => new BlobSource(new Blob([content as BlobPart]), "fixture");

/** The file that `isosplat extract --mesh` writes, and the comment in it. */
function extracted(format: string, ...more: string[]): { file: Buffer; comment: string } {
  const path = join(folder, `part.${format}`);
  execFileSync(isosplat, [
    ...["extract", store, "-i", String(isovalue), "--mesh", "-o", path, "--force"],
    ...more,
  ]);
  const file = readFileSync(path);
  const [comment = ""] = file.toString("latin1").match(/isosurface [ -~]*?isosplat [\w.-]+/) ?? [];
  return { file, comment };
}

/** The edges of an STL file that are not used as often in one direction as in the other. */
function openEdges(stl: Buffer): number {
  const surplus = new Map<string, number>();
  for (let at = 84; at < stl.length; at += 50) {
    const corners = [0, 1, 2].map((i) =>
      stl.subarray(at + 12 + 12 * i, at + 24 + 12 * i).toString("hex"),
    );
    corners.forEach((from, i) => {
      const to = corners[(i + 1) % 3] ?? "";
      const [key, step] = from < to ? [from + to, 1] : [to + from, -1];
      if (from !== to) surplus.set(key, (surplus.get(key) ?? 0) + step);
    });
  }
  return [...surplus.values()].filter((count) => count !== 0).length;
}

/** The largest difference of a coordinate of two STL files with the same triangles. */
function largestDifference(a: Buffer, b: Buffer): number {
  expect(a.length).toBe(b.length);
  let largest = 0;
  for (let at = 84; at < a.length; at += 50) {
    for (let i = 12; i < 48; i += 4) {
      largest = Math.max(largest, Math.abs(a.readFloatLE(at + i) - b.readFloatLE(at + i)));
    }
  }
  return largest;
}

async function saved(options: SaveSurfaceOptions): Promise<Buffer> {
  const { file } = await saveSurface(source(), isovalue, options);
  return Buffer.from(await file.arrayBuffer());
}

describe("a surface as a file", () => {
  test.each(meshFormats)("has the program's bytes: %s", async (format) => {
    const { file, comment } = extracted(format);
    expect(comment).toContain(`isosurface ${isovalue}`);
    expect(file.equals(await saved({ format, comment }))).toBe(true);
  });

  test("has the program's bytes at a coarser level", async () => {
    const { file, comment } = extracted("ply", "--level", "1");
    expect(file.equals(await saved({ format: "ply", level: 1, comment }))).toBe(true);
  });

  test("has the program's bytes in a box", async () => {
    const reader = await SurfaceReader.open(source(), new AbortController().signal);
    const { origin, spacing, direction } = reader.info;
    expect(direction).toEqual([1, 0, 0, 0, 1, 0, 0, 0, 1]);
    reader.close();
    const low = [0.5, 0, 0.25].map((share, i) => share * ((voxels[i] ?? 0) - 1));
    const high = [1, 0.75, 0.75].map((share, i) => share * ((voxels[i] ?? 0) - 1));
    const world = [low, high].flatMap((corner) =>
      corner.map((n, i) => (origin[i] ?? 0) + n * (spacing[i] ?? 0)),
    );
    const box = { low: [0.5, 0, 0.25], high: [1, 0.75, 0.75] } as const;
    for (const closed of [true, false]) {
      const how = closed ? "--closed" : "--open";
      const { file, comment } = extracted("stl", "--box", world.join(), how);
      const mine = await saved({ format: "stl", comment, box, closed });
      expect(file.length).toBeGreaterThan(100_000);
      // Cuts of a box in the world are rounded differently.
      if (closed) expect(largestDifference(file, mine)).toBeLessThan(1e-4);
      else expect(file.equals(mine)).toBe(true);
    }
  });

  test("has the program's bytes where oblique planes cut it", async () => {
    const planes = [
      { normal: [1, 2, -1], offset: 150 },
      { normal: [-1, 0, -0.5], offset: -120.25 },
    ] as const;
    const args = planes.map(({ normal, offset }) => `--clip-plane=${[...normal, offset]}`);
    for (const format of meshFormats) {
      const { file, comment } = extracted(format, "--closed", ...args);
      const mine = await saved({ format, comment, planes, closed: true });
      expect(file.length).toBeGreaterThan(10_000);
      expect(file.equals(mine)).toBe(true);
    }
  });

  test("has two triangles at each edge if it is closed", async () => {
    const planes = [{ normal: [1, 2, -1], offset: 150 }] as const;
    const box = { low: [0.1, 0, 0.25], high: [1, 0.75, 0.9] } as const;
    expect(openEdges(await saved({ format: "stl", planes, box }))).toBe(0);
    expect(openEdges(await saved({ format: "stl", closed: false, box }))).toBeGreaterThan(100);
  });

  test("stays open by default if missing voxels leave holes, as the program's does", async () => {
    const size = 24;
    const ball = Float32Array.from({ length: size ** 3 }, (_, i) => {
      const at = [i % size, Math.floor(i / size) % size, Math.floor(i / size ** 2)];
      const distance = Math.hypot(...at.map((n) => n - 11.5));
      return at[0] === 11 && at[1] === 11 && (at[2] ?? 0) > 11 ? Number.NaN : 10 - distance;
    });
    const raw = join(folder, "holed.raw");
    const store = join(folder, "holed.isosplat");
    writeFileSync(raw, new Uint8Array(ball.buffer));
    const layout = ["--dims", "24,24,24", "--type", "f32", "-q", "-o", store, "--no-thumbnail"];
    execFileSync(isosplat, ["build", raw, ...layout]);
    const of = new BlobSource(new Blob([readFileSync(store)]), "ball");
    const { closed, file } = await saveSurface(of, 2, { format: "stl" });
    expect(closed).toBe(false);
    expect(openEdges(Buffer.from(await file.arrayBuffer()))).toBeGreaterThan(0);
    await expect(saveSurface(of, 2, { format: "stl", closed: true })).rejects.toSatisfy(hasHoles);
    const tooLarge = "expected a mesh of less than 4 GiB, found 5 GiB: choose PLY";
    expect(hasHoles(new CoreError("invalid_argument", tooLarge))).toBe(false);
    const above = { low: [0.6, 0, 0], high: [1, 1, 1] } as const;
    const part = await saveSurface(of, 2, { format: "stl", box: above });
    expect(part.closed).toBe(true);
    expect(openEdges(Buffer.from(await part.file.arrayBuffer()))).toBe(0);
  });

  test("refuses planes that an open surface cannot have", async () => {
    const planes = [{ normal: [1, 0, 0], offset: 1 }] as const;
    await expect(saveSurface(source(), isovalue, { planes })).rejects.toThrow(
      "found an open one: set closed to true",
    );
    const wrong = [{ normal: [0, 0, 0], offset: 1 }] as const;
    await expect(saveSurface(source(), isovalue, { planes: wrong, format: "stl" })).rejects.toThrow(
      "normal other than 0,0,0",
    );
  });

  test("has the predicted size", async () => {
    const n = 60;
    const ball = Uint8Array.from({ length: n ** 3 }, (_, i) => {
      const [x, y, z] = [i % n, Math.floor(i / n) % n, Math.floor(i / n ** 2)];
      return Math.max(0, 250 - 6 * Math.hypot(x - n / 2, y - n / 2, z - n / 2));
    });
    const header = `NRRD0004\ntype: uint8\ndimension: 3\nsizes: ${n} ${n} ${n}\nencoding: raw\n\n`;
    writeFileSync(join(folder, "ball.nrrd"), Buffer.concat([Buffer.from(header), ball]));
    const built = join(folder, "ball.isosplat");
    execFileSync(isosplat, ["build", join(folder, "ball.nrrd"), "-o", built, "--quiet"]);
    const content = new Uint8Array(readFileSync(built));
    for (const format of meshFormats) {
      const forecast = await forecastSurface(source(content), 100.5, { format });
      const { file, triangles } = await saveSurface(source(content), 100.5, { format });
      expect(forecast.problem).toBeUndefined();
      expect(Math.abs(forecast.triangles / triangles - 1)).toBeLessThan(0.1);
      expect(Math.abs(forecast.fileBytes / file.size - 1)).toBeLessThan(0.1);
      expect(forecast.bytesToFetch).toBeGreaterThan(1000);
      // Without statistics of the level, and in a box, it is an upper bound.
      for (const some of [{ level: 1 }, { box: { low: [0, 0, 0], high: [0.5, 1, 1] } }] as const) {
        const options = { format, ...some } as SaveSurfaceOptions;
        const bound = await forecastSurface(source(content), 100.5, options);
        const made = await saveSurface(source(content), 100.5, options);
        expect(bound.triangles).toBeGreaterThan(0.95 * made.triangles);
      }
    }
  });

  test("reports its progress, and ends with its signal", async () => {
    const shares: number[] = [];
    await saveSurface(source(), isovalue, { progress: (share) => shares.push(share) });
    expect(shares.length).toBeGreaterThan(3);
    expect(shares).toEqual(shares.toSorted((a, b) => a - b));
    expect(shares.at(-1)).toBe(1);
    const cancel = new AbortController();
    const progress = () => cancel.abort(new Error("no more"));
    await expect(
      saveSurface(source(), isovalue, { signal: cancel.signal, progress }),
    ).rejects.toThrow("no more");
  });

  test("has no triangles where there is no surface", async () => {
    const { file, triangles } = await saveSurface(source(), 1e6, { format: "stl" });
    expect(triangles).toBe(0);
    expect(file.size).toBe(84);
  });

  test("refuses what it cannot do", async () => {
    await expect(saveSurface(source(), isovalue, { level: 40 })).rejects.toThrow(
      /expected a level from 0 to \d, found 40/,
    );
    const chunk = { cells: 30_000_000, bytes: 1e6, block: [0, 0, 0] };
    const huge = forecastOf(
      { metadata: {} } as StoreInfo,
      isovalue,
      { level: 0, format: "stl", closed: true, hasBox: false },
      [chunk] as never,
    );
    expect(huge.problem).toContain("30 million cells: choose a coarser level");
  });

  test("reports the damaged block by its name", async () => {
    const reader = await SurfaceReader.open(source(), new AbortController().signal);
    const [chunk] = await reader.chunksOf(isovalue, 0, new AbortController().signal);
    reader.close();
    if (!chunk) throw new Error("expected a chunk, found none");
    const damaged = bytes.slice();
    damaged[chunk.offset + 10] = (damaged[chunk.offset + 10] ?? 0) ^ 1;
    await expect(saveSurface(source(damaged), isovalue)).rejects.toMatchObject({
      kind: "damaged-part",
      message: expect.stringContaining(`block ${chunk.block.join(".")}`),
    });
  });

  test("reports a store that was cut short", async () => {
    await expect(saveSurface(source(bytes.slice(0, 5000)), isovalue)).rejects.toMatchObject({
      kind: "cut-short",
    });
  });
});

test("has the area and volume of a ball", async () => {
  const reader = await SurfaceReader.open(source(), new AbortController().signal);
  const extent = await surfaceExtent(reader, isovalue);
  reader.close();
  expect(extent.volumeAbove).toBeGreaterThan(0);
  expect(extent.volumeAbove).toBeLessThan(extent.gridVolume);
  expect(extent.area).toBeGreaterThan(0);
});
