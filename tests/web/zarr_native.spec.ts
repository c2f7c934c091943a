/** The program reads Zarr from folders: the volumes that the browser reads from addresses. */
import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, truncateSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { afterAll, describe, expect, test } from "vitest";
import { program } from "../browser/support/server.ts";
import { writeArray, writeGroup, writeJson } from "../support/zarr.ts";
import { plainZarr, valueAt, voxels, zarrVariants } from "../support/zarr_variants.ts";

const folder = mkdtempSync(join(tmpdir(), "isosplat-zarr-"));
afterAll(() => rmSync(folder, { recursive: true, force: true }));

/** What the program writes to its standard output; throws with what it writes to the other one. */
function run(...args: string[]): string {
  return execFileSync(program, args, { encoding: "utf8", stdio: ["ignore", "pipe", "pipe"] });
}

function errorOf(...args: string[]): string {
  try {
    run(...args);
  } catch (error) {
    return (error as { stderr: string }).stderr;
  }
  throw new Error(`expected an error of ${args.join(" ")}, found none`);
}

interface Built {
  mesh: Buffer;
  info: { voxels: number[]; spacing: number[]; origin: number[]; metadata: Metadata };
}

interface Metadata {
  name: string;
  notes?: string[];
  source: { format: string };
}

let count = 0;

/** The store of a volume: one of its surfaces, and its description. */
function build(volume: string, ...options: string[]): Built {
  const store = join(folder, `${++count}.isosplat`);
  const mesh = join(folder, `${count}.ply`);
  run("build", volume, "-o", store, "--no-thumbnail", ...options);
  run("extract", store, "-i", "4000.5", "--mesh", "-o", mesh);
  const ply = readFileSync(mesh);
  // Its header names the store.
  return {
    mesh: ply.subarray(ply.indexOf("end_header")),
    info: JSON.parse(run("info", store, "--json")),
  };
}

/** The surface of a raw file with these voxels. */
function raw(value: (x: number, y: number, z: number) => number, ...options: string[]): Buffer {
  const all = new Uint16Array(voxels[0] * voxels[1] * voxels[2]);
  let at = 0;
  for (let z = 0; z < voxels[2]; ++z) {
    for (let y = 0; y < voxels[1]; ++y) {
      for (let x = 0; x < voxels[0]; ++x) all[at++] = value(x, y, z);
    }
  }
  const file = join(folder, "voxels.raw");
  writeFileSync(file, all);
  return build(file, "--dims", voxels.join("x"), "--type", "u16", ...options).mesh;
}

describe("arrays", () => {
  test.each(zarrVariants)("%s", async (name, options) => {
    const path = join(folder, `${name.replaceAll(/\W+/g, "-")}.zarr`);
    await writeArray(path, options);
    const { mesh, info } = build(path);
    expect(info.metadata.source.format).toBe("Zarr");
    expect(info.voxels).toEqual([...voxels]);
    expect(info.metadata.notes).toContain("its lengths have no unit: millimetres are assumed");
    expect(mesh.equals(raw(valueAt))).toBe(true);
  });

  test("absent chunks have the fill value, and are counted", async () => {
    const path = join(folder, "absent.zarr");
    const isAbsent = (chunk: readonly number[]) => chunk.join() === "1,0,2";
    await writeArray(path, { ...plainZarr, fill: 7, isAbsent });
    const { mesh, info } = build(path);
    const isIn = (x: number, y: number, z: number) => z >= 4 && z < 8 && y < 4 && x >= 10;
    expect(mesh.equals(raw((x, y, z) => (isIn(x, y, z) ? 7 : valueAt(x, y, z))))).toBe(true);
    expect(info.metadata.notes).toContain(
      "1 of 27 chunks are absent: their voxels have the fill value",
    );
  });

  test("a chunk that is cut short or damaged is one error", async () => {
    const path = join(folder, "damaged.zarr");
    await writeArray(path, { ...plainZarr, isCompressed: true });
    const chunk = join(path, "1.1.1");
    const whole = readFileSync(chunk);
    truncateSync(chunk, whole.length - 9);
    const out = ["-o", join(folder, "damaged.isosplat")];
    expect(errorOf("build", path, ...out)).toContain(
      "1.1.1: expected compressed data of 160 bytes",
    );
    const changed = Buffer.from(whole);
    changed[whole.length >> 1] = ~(changed[whole.length >> 1] ?? 0) & 255;
    writeFileSync(chunk, changed);
    expect(errorOf("build", path, ...out)).toContain("1.1.1: expected");
    writeFileSync(chunk, "");
    expect(errorOf("build", path, ...out)).toContain("1.1.1");
  });

  test("metadata that contradict each other, or ask for too much, are one error", () => {
    const path = join(folder, "hostile.zarr");
    const good = {
      zarr_format: 2,
      shape: [9, 11, 13],
      chunks: [4, 4, 5],
      dtype: "<u2",
      compressor: null,
      fill_value: 0,
      order: "C",
      filters: null,
    };
    const cases: [change: object, message: string][] = [
      [{ shape: [9, 11] }, "expected chunks with 2 axes"],
      [{ shape: [9, 11, -1] }, "expected a shape of 1 to 16 whole numbers from 1"],
      [{ shape: [2 ** 40, 2 ** 40, 13] }, "expected a shape of fewer than 2^64 bytes"],
      [{ chunks: [0, 4, 5] }, "expected chunks of 1 to 16 whole numbers from 1"],
      [{ chunks: [4000, 4000, 5000] }, "expected chunks of at most 256 MiB"],
      [{ dtype: "<c16" }, 'found the type "<c16"'],
      [{ dtype: 3 }, "found the type"],
      [{ compressor: { id: "jpeg" } }, 'found the codec "jpeg"'],
      [{ fill_value: "many" }, "expected a fill value of the array's type"],
    ];
    for (const [change, message] of cases) {
      writeJson(join(path, ".zarray"), { ...good, ...change });
      expect(errorOf("build", path, "-o", join(folder, "x.isosplat"))).toContain(message);
    }
    writeFileSync(join(path, ".zarray"), "{");
    expect(errorOf("info", path)).toContain("expected an object of JSON");
  });
});

describe("random damage", () => {
  test("ends in a volume or in one error, never in a crash", async () => {
    const path = join(folder, "random.zarr");
    const options = { ...plainZarr, version: 3, shards: [2, 1, 3], isCompressed: true } as const;
    await writeArray(path, options);
    const files = ["zarr.json", "c/0/0/0", "c/1/1/0"].map((name) => join(path, name));
    const whole = files.map((file) => readFileSync(file));
    let seed = 1;
    const random = (most: number) => {
      seed = (1103515245 * seed + 12345) % 2 ** 31;
      return seed % most;
    };
    let refused = 0;
    for (let i = 0; i < 80; ++i) {
      const which = random(files.length);
      const [file, bytes] = [files[which] as string, whole[which] as Buffer];
      const changed = Buffer.from(
        bytes.subarray(0, random(4) === 0 ? random(bytes.length) : bytes.length),
      );
      for (let n = random(4); n > 0 && changed.length > 0; --n) {
        changed[random(changed.length)] = random(256);
      }
      writeFileSync(file, changed);
      try {
        run("build", path, "-o", join(folder, "random.isosplat"), "--no-thumbnail", "--force");
      } catch (error) {
        const { status, stderr } = error as { status: number; stderr: string };
        expect([status, stderr.match(/^isosplat: /gm)?.length]).toEqual([1, 1]);
        ++refused;
      }
      writeFileSync(file, bytes);
    }
    expect(refused).toBeGreaterThan(20);
  });
});

describe.each([
  ["0.4", 2],
  ["0.5", 3],
] as const)("an image of OME-Zarr %s", (version, format) => {
  const multiscale = {
    name: "brain",
    axes: [
      { name: "t", type: "time", unit: "second" },
      { name: "c", type: "channel" },
      ...["z", "y", "x"].map((name) => ({ name, type: "space", unit: "micrometer" })),
    ],
    datasets: ["0", "1"].map((path, i) => ({
      path,
      coordinateTransformations: [
        { type: "scale", scale: [1, 1, 2, 0.5 * 2 ** i, 0.5 * 2 ** i] },
        { type: "translation", translation: [0, 0, 0, 0.25 * i, 0.25 * i] },
      ],
    })),
    coordinateTransformations: [{ type: "scale", scale: [1, 1, 10, 10, 10] }],
  };
  const path = join(folder, `brain-${version}.zarr`);
  const value = (x: number, y: number, z: number, c: number, t: number) =>
    valueAt(x, y, z) + 10_000 * c + 30_000 * t;
  const write = async () => {
    const channels = [{ label: "DAPI", color: "0000FF" }, { label: "GFP" }, {}];
    const attributes = { multiscales: [multiscale], omero: { channels } };
    writeGroup(path, format, format === 3 ? { ome: { version, ...attributes } } : attributes);
    for (const [i, step] of [1, 2].entries()) {
      await writeArray(join(path, String(i)), {
        version: format,
        shape: [2, 3, 9, Math.ceil(11 / step), Math.ceil(13 / step)],
        chunks: [1, 2, 4, 4, 5],
        value: ([t = 0, c = 0, z = 0, y = 0, x = 0]) => value(x * step, y * step, z, c, t),
      });
    }
  };

  test("scales, units, channels and times", async () => {
    await write();
    expect(errorOf("info", path)).toMatch(/--time-step/);
    expect(errorOf("info", path, "--time-step", "0")).toMatch(/--channel/);
    const { mesh, info } = build(path, "--channel", "0", "--time-step", "0");
    expect(info).toMatchObject({
      voxels: [...voxels],
      spacing: [0.005, 0.005, 0.02],
      origin: [0, 0, 0],
      metadata: { name: `brain-${version}`, source: { format: "OME-Zarr" } },
    });
    expect(mesh.equals(raw(valueAt, "--spacing", "0.005,0.005,0.02"))).toBe(true);
    const coarse = build(path, "--channel", "0", "--time-step", "0", "--dataset", "1").info;
    expect(coarse.voxels).toEqual([7, 6, 9]);
    expect(coarse.origin.map((n) => n.toFixed(6))).toEqual(["0.002500", "0.002500", "0.000000"]);
    const named = build(join(path, "1"), "--channel", "0", "--time-step", "0").info;
    expect(named.voxels).toEqual([7, 6, 9]);
    expect(errorOf("info", path, "--dataset", "7")).toContain("expected one of its scales");
    const last = JSON.parse(run("info", path, "--channel", "2", "--time-step", "1", "--json"));
    expect(last.range[0]).toBe(value(0, 0, 0, 2, 1));
  });

  test("the program builds a scene of its channels", async () => {
    await write();
    const scene = join(folder, `channels-${version}.isobundle`);
    run("build", path, "--time-step", "0", "-o", scene, "--no-thumbnail");
    const { layers } = JSON.parse(run("info", scene, "--json"));
    expect(layers.map(({ name }: { name: string }) => name).slice(0, 2)).toEqual(["DAPI", "GFP"]);
  });
});
