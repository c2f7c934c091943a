// Builds the surfaces of a segmentation's labels. Measures the rate, the size, and the volumes that
// the surfaces enclose.
import { readFileSync, statSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { body, type LabelVolume, manyLabels, organs } from "../support/labels.ts";
import type { Bench, Benchmark } from "./harness/benchmark.ts";

interface Layer {
  store: string;
  label: { value: number; voxels: number; volume: number };
  surfaces: { isovalue: number }[];
}

/** The volume within the triangles of a binary STL file. */
function stlVolume(path: string): number {
  const file = readFileSync(path);
  const count = file.readUInt32LE(80);
  let six = 0;
  for (let i = 0; i < count; ++i) {
    const [ax, ay, az, bx, by, bz, cx, cy, cz] = Array.from({ length: 9 }, (_, k) =>
      file.readFloatLE(84 + 50 * i + 12 + 4 * k),
    ) as [number, number, number, number, number, number, number, number, number];
    six += ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx);
  }
  return Math.abs(six) / 6;
}

/** Builds `runs` times, and reports the rate and the sizes. */
async function build(bench: Bench, name: string, volume: LabelVolume, runs: number) {
  const path = join(bench.folder, "labels.nrrd");
  const bundle = join(bench.folder, "labels.isobundle");
  writeFileSync(path, volume.nrrd());
  const voxels = volume.labels.length;
  const seconds: number[] = [];
  for (let i = 0; i < runs; ++i) {
    const call = ["build", path, "--labels", "-o", bundle, "--no-thumbnail", "--force"];
    seconds.push((await bench.command(bench.isosplat, call)).seconds);
  }
  const rates = seconds.map((s) => voxels / s / 1e6);
  bench.report(name, "rate", "Mvoxel/s", rates, { atLeast: 20 });
  bench.report(name, "build", "s", seconds);
  const bytes = statSync(bundle).size;
  bench.report(name, "bundle", "% of 16-bit voxels", (100 * bytes) / (2 * voxels), { atMost: 2 });
  const header = readFileSync(bundle).subarray(0, 64);
  const first = header.readUInt32LE(12) + Number(header.readBigUInt64LE(24));
  bench.report(name, "header and coarse parts", "KB", first / 1000, { atMost: 600 });
  return bundle;
}

/** Compares the volumes within the surfaces of labels (1,000 to 200,000 voxels) with their voxels. */
async function compareVolumes(bench: Bench, name: string, bundle: string): Promise<void> {
  const folder = join(bench.folder, "unpacked");
  await bench.command(bench.isosplat, ["unbundle", bundle, "-o", folder, "--force"]);
  const scene = JSON.parse(readFileSync(join(folder, "scene.json"), "utf8")) as { layers: Layer[] };
  const differences: number[] = [];
  for (const { store, label, surfaces } of scene.layers) {
    if (label.voxels < 1000 || label.voxels > 200_000) continue;
    const mesh = join(bench.folder, "label.stl");
    const isovalue = String(surfaces[0]?.isovalue);
    const call = ["extract", join(folder, store), "-i", isovalue, "--mesh", "-o", mesh, "--force"];
    await bench.command(bench.isosplat, call);
    differences.push(100 * Math.abs(stlVolume(mesh) / label.volume - 1));
  }
  differences.sort((a, b) => a - b);
  const within = differences.filter((difference) => difference <= 1).length;
  bench.report(name, "labels of 1,000 to 200,000 voxels", "labels", differences.length);
  bench.report(name, "of them within 1 % of their voxels", "labels", within);
  bench.report(name, "largest difference", "%", differences.at(-1) ?? 0, { atMost: 1 });
}

export default {
  title: "surfaces of labels",
  async run(bench) {
    for (const [name, volume] of [
      ["105 labels in 4 % of 317 × 317 × 835", organs()],
      ["105 labels in 29 % of 317 × 317 × 835", body()],
    ] as const) {
      const bundle = await build(bench, name, volume, 3);
      await compareVolumes(bench, name, bundle);
    }
    await build(bench, "1,000 labels, 200³", manyLabels(1000), 1);
  },
} satisfies Benchmark;
