/**
 * Compares the builder in WebAssembly with the program: the same volume must give the same bytes.
 */
import { execFileSync } from "node:child_process";
import { existsSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { brotliCompressSync } from "node:zlib";
import { afterAll, beforeAll, describe, expect, test } from "vitest";
import type { Encoder, VolumeDescription, VoxelType } from "../../web/builder/index.ts";
import type { CompiledModule, Core } from "../../web/core/index.ts";
import { readNrrd } from "../bench/harness/flying_edges.ts";
import { describeStore } from "../support/describe_store.ts";
import { builderProgram, buildLocally, localEncoder } from "../support/local_build.ts";
import { core as load } from "./fixture.ts";

const root = fileURLToPath(new URL("../..", import.meta.url));
const isosplat = join(root, "build/release/native/cli/isosplat");
const volumes = process.env.ISOSPLAT_VOLUMES ?? join(root, "../shared/volumes");
const folder = mkdtempSync(join(tmpdir(), "isosplat-builder-"));

let core: Core;
let program: CompiledModule;
let encoders: Encoder[];

beforeAll(async () => {
  core = await load();
  program = await builderProgram();
  encoders = [await localEncoder(program), await localEncoder(program)];
});

afterAll(() => rmSync(folder, { recursive: true, force: true }));

const arrays = {
  u8: Uint8Array,
  i8: Int8Array,
  u16: Uint16Array,
  i16: Int16Array,
  u32: Uint32Array,
  i32: Int32Array,
  f32: Float32Array,
  f64: Float64Array,
} as const;
const nrrdTypes = { u: "uint", i: "int", f: "f" } as const;

/** A ball in noise, whose values fit into 8 bits or fill more. */
function voxelsOf(type: keyof typeof arrays, [nx, ny, nz]: readonly [number, number, number]) {
  const voxels = new arrays[type](nx * ny * nz);
  const isFloat = type.startsWith("f");
  const high = type.endsWith("8") ? 100 : 3000;
  let noise = 1;
  let at = 0;
  for (let z = 0; z < nz; ++z) {
    for (let y = 0; y < ny; ++y) {
      for (let x = 0; x < nx; ++x) {
        noise = (Math.imul(noise, 1664525) + 1013904223) >>> 0;
        const r2 = (x - nx / 2) ** 2 + (y - ny / 2) ** 2 + 2 * (z - nz / 2) ** 2;
        const value = Math.max(0, high - r2 * (high / 4000)) + (noise >>> 28);
        voxels[at++] = isFloat ? value * 0.7123 - 20 : Math.floor(value);
      }
    }
  }
  if (isFloat) voxels.fill(Number.NaN, 500, 900);
  return new Uint8Array(voxels.buffer);
}

/** The store that the program builds from a file. */
function buildNatively(file: string, ...options: string[]): Uint8Array {
  const store = join(folder, "native.isosplat");
  execFileSync(isosplat, ["build", file, "-o", store, "--force", ...options], { stdio: "pipe" });
  return readFileSync(store);
}

describe("a store equals that of the program, byte by byte", () => {
  const cases: [keyof typeof arrays, [number, number, number]][] = [
    ["u8", [67, 130, 70]],
    ["i8", [65, 64, 66]],
    ["u16", [150, 75, 131]],
    ["i16", [2, 3, 129]],
    ["u32", [64, 65, 33]],
    ["i32", [70, 2, 66]],
    ["f32", [90, 71, 68]],
    ["f64", [66, 35, 40]],
  ];
  test.each(cases)("%s, %j voxels", async (type, voxels) => {
    const bits = type.slice(1);
    const name =
      type === "f32"
        ? "float"
        : type === "f64"
          ? "double"
          : `${nrrdTypes[type[0] as "u" | "i"]}${bits}`;
    const data = voxelsOf(type, voxels);
    const header = [
      "NRRD0004",
      `type: ${name}`,
      "dimension: 3",
      "space: left-posterior-superior",
      `sizes: ${voxels.join(" ")}`,
      "space directions: (0.5,0,0) (0,0.6,0.08) (0,0,1.25)",
      "space origin: (-10,20,30.5)",
      "endian: little",
      "encoding: raw",
    ];
    const file = join(folder, `${type}.nrrd`);
    writeFileSync(file, Buffer.concat([Buffer.from(`${header.join("\n")}\n\n`), data]));
    const native = buildNatively(file);
    const volume = describeStore(core, native);
    const { store, report, fractions } = await buildLocally(program, encoders, volume, data);
    expect(report.voxelBytes).toBe(data.byteLength);
    expect(report.storeBytes).toBe(native.byteLength);
    expect(Buffer.compare(store, native)).toBe(0);
    expect(fractions).toEqual([...fractions].sort((a, b) => a - b));
  });

  test.skipIf(!existsSync(join(volumes, "engine.nhdr")))(
    "engine, of the real volumes",
    async () => {
      const { data } = readNrrd(join(volumes, "engine.nhdr"));
      const native = buildNatively(join(volumes, "engine.nhdr"));
      const { store } = await buildLocally(program, encoders, describeStore(core, native), data);
      expect(Buffer.compare(store, native)).toBe(0);
    },
    120_000,
  );
});

const small: VolumeDescription = {
  voxels: [70, 40, 30],
  type: "u8",
  name: "ball",
  format: "raw",
  slope: -0.25,
  intercept: 100,
};
const smallVoxels = () => voxelsOf("u8", [70, 40, 30]);

test("the number of encoders does not change the store", async () => {
  const one = await buildLocally(program, encoders.slice(0, 1), small, smallVoxels());
  const two = await buildLocally(program, encoders, small, smallVoxels());
  expect(Buffer.compare(one.store, two.store)).toBe(0);
  expect(one.report.contentId).toBe(two.report.contentId);
});

describe("errors", () => {
  const build = (volume: object, limits = {}) =>
    buildLocally(program, encoders, volume as VolumeDescription, smallVoxels(), { limits });

  test.each([
    [{ voxels: [70, 40] }, '"voxels"'],
    [{ voxels: [1, 40, 30] }, '"voxels"'],
    [{ voxels: [70.5, 40, 30] }, '"voxels"'],
    [{ type: "u12" as VoxelType }, '"type"'],
    [{ spacing: [1, 0, 1] }, '"spacing"'],
    [{ origin: [1, 2, "3"] }, '"origin"'],
    [{ direction: [1, 0, 0, 1, 0, 0, 0, 0, 1] }, '"direction"'],
    [{ slope: 0 }, '"slope"'],
    [{ name: 5 }, '"name"'],
    [{ notes: "one" }, '"notes"'],
    [{ fetchWeight: 0 }, '"fetchWeight"'],
  ])("a description with %j is refused", async (wrong, key) => {
    await expect(build({ ...small, ...wrong })).rejects.toThrow(key);
  });

  test("a volume that does not fit is refused unread; the message names memory and program", async () => {
    const large = { ...small, voxels: [4000, 4000, 4000] };
    const refused = build(large, { memoryBytes: 2 ** 30 });
    await expect(refused).rejects.toThrow(/built in 1024 MiB of memory.*isosplat build/);
    await expect(refused).rejects.toHaveProperty("status", "out_of_memory");
  });

  test("a number of voxels that differs from the description is refused", async () => {
    const short = smallVoxels().subarray(1);
    await expect(buildLocally(program, encoders, small, short)).rejects.toThrow(
      /expected 84000 bytes of voxels, found 83999/,
    );
  });

  test("an encoder that fails ends the build", async () => {
    const [first] = encoders;
    if (!first) throw new Error("no encoder");
    const broken: Encoder = { ...first, encode: () => Promise.reject(new Error("lost")) };
    await expect(buildLocally(program, [broken], small, smallVoxels())).rejects.toThrow("lost");
  });

  test.each([
    ["cut", (block: Uint8Array) => block.subarray(0, block.byteLength - 1)],
    ["longer", (block: Uint8Array) => Buffer.concat([block, Buffer.from([0])])],
    ["empty", () => new Uint8Array()],
    ["of other bytes", (block: Uint8Array) => block.map((byte) => byte ^ 0xff)],
  ])("a block that is %s is refused", async (_, damage) => {
    const [first] = encoders;
    if (!first) throw new Error("no encoder");
    const damaged: Encoder = {
      ...first,
      encode: async (task) => damage(await first.encode(task)),
    };
    await expect(buildLocally(program, [damaged], small, smallVoxels())).rejects.toHaveProperty(
      "status",
      "invalid_argument",
    );
  });

  test("a truncated task is refused", async () => {
    const [first] = encoders;
    if (!first) throw new Error("no encoder");
    const cutting: Encoder = { ...first, encode: (task) => first.encode(task.subarray(0, 900)) };
    await expect(buildLocally(program, [cutting], small, smallVoxels())).rejects.toThrow(
      /task of an encoder/,
    );
  });

  test("a build is cancelled between two blocks", async () => {
    const cancel = new AbortController();
    const cancelling = encoders.map((encoder) => ({
      ...encoder,
      encode: (task: Uint8Array) => {
        cancel.abort();
        return encoder.encode(task);
      },
    }));
    const cancelled = buildLocally(program, cancelling, small, smallVoxels(), {
      signal: cancel.signal,
    });
    await expect(cancelled).rejects.toThrow(/abort/i);
  });
});

test("the module takes at most 120 KB on the network", () => {
  const bytes = ["wasm", "js"].map((suffix) =>
    readFileSync(join(root, `build/wasm/web/isosplat-builder.${suffix}`)),
  );
  const packed = bytes.map((part) => brotliCompressSync(part).byteLength); // as vite.config.ts does
  expect(packed.reduce((sum, size) => sum + size)).toBeLessThanOrEqual(120_000);
});
