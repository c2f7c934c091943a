// The size of stores, the bytes that one isovalue needs, and the time to build stores.
import { existsSync, rmSync, statSync } from "node:fs";
import { join } from "node:path";
import type { Bench, Benchmark } from "./harness/benchmark.ts";
import { median } from "./harness/results.ts";

interface Case {
  volume: string;
  /** The name in the table, if it differs from the volume's. */
  name?: string;
  /** Largest allowed size of the store relative to the voxels. */
  ratio?: number;
  /** Largest allowed number of bytes of level 0 for an isovalue. */
  isovalues?: Record<string, number>;
  /** Smallest allowed rate, million voxels per second. */
  rate?: number;
  options?: string[];
}

const cases: Case[] = [
  { volume: "engine.nhdr", ratio: 0.7, isovalues: { "60.5": 430e3 }, rate: 60 },
  { volume: "bonsai.nhdr", ratio: 0.85, isovalues: { "100.5": 430e3 }, rate: 60 },
  { volume: "aneurysm.nhdr", ratio: 0.85, isovalues: { "100.5": 190e3 } },
  { volume: "bunny_ct_i16.nrrd", ratio: 0.52, isovalues: { "1000.5": 4.8e6 }, rate: 40 },
  {
    volume: "bunny_ct_i16.nrrd",
    name: "bunny as 8 bit",
    rate: 60,
    options: ["--u8", "-1000", "3096"],
  },
  { volume: "lobster.nhdr", ratio: 0.85 },
  { volume: "statueLeg.nhdr", ratio: 0.85 },
  { volume: "BostonTeapot.nhdr", ratio: 0.85 },
  { volume: "hydrogenAtom.nhdr", ratio: 0.85 },
  { volume: "shockwave.nhdr", ratio: 0.85 },
  { volume: "eun_brain.nii.gz", ratio: 0.85 },
  { volume: "iron_protein.vtk", ratio: 0.85 },
];

interface Report {
  ratio: number;
  megavoxels_per_second: number[];
  [isovalue: `isovalue_${string}`]: { bytes: number };
}

/** 2048×2048×1024 bytes, built by the program itself with 1 GiB. */
async function buildLarge(
  bench: Bench,
  tool: string,
  bunnyRate: number | undefined,
): Promise<void> {
  if (process.env.ISOSPLAT_BENCH_LARGE !== "1") {
    bench.skip("2048×2048×1024", "takes minutes and 8 GB of disk; set ISOSPLAT_BENCH_LARGE=1");
    return;
  }
  const raw = join(bench.folder, "large_2048x2048x1024_u8.raw");
  const store = join(bench.folder, "large.isosplat");
  await bench.command(tool, ["--generate", raw, "2048", "2048", "1024"]);
  const built = await bench.command(bench.isosplat, [
    "build",
    raw,
    "-o",
    store,
    "--memory",
    "1G",
    "--no-thumbnail",
  ]);
  const rate = (2048 * 2048 * 1024) / 1e6 / built.seconds;
  bench.report("2048×2048×1024", "peak memory", "GB", built.peakBytes / 1e9, { atMost: 1.2 });
  bench.report("2048×2048×1024", "rate", "Mvoxel/s", rate);
  bench.report("2048×2048×1024", "store / raw", "", statSync(store).size / statSync(raw).size);
  if (bunnyRate !== undefined) {
    bench.report("2048×2048×1024", "rate / bunny's", "", rate / bunnyRate, { atLeast: 0.7 });
  }
  rmSync(raw);
}

export default {
  title: "stores: size, bytes for an isovalue, rate of building",
  quick: true,
  async run(bench) {
    const tool = join(bench.root, "build/release/tests/bench/build/isosplat_build_bench");
    if (!existsSync(tool)) throw new Error(`${tool} is not built: npm run build`);
    let bunnyRate: number | undefined;
    for (const { volume, name, ratio, isovalues, rate, options } of cases) {
      const path = bench.volume(volume);
      if (!path) continue;
      const what = name ?? volume.replace(/\..*/, "");
      bench.say(what);
      const args = [path, "--runs", String(rate ? bench.runs : 1), ...(options ?? [])];
      const { stdout } = await bench.command(tool, [...args, ...Object.keys(isovalues ?? {})]);
      const report = JSON.parse(stdout) as Report;
      bench.report(what, "store / raw", "", report.ratio, ratio ? { atMost: ratio } : undefined);
      for (const [isovalue, most] of Object.entries(isovalues ?? {})) {
        const bytes = report[`isovalue_${isovalue}`]?.bytes ?? Number.NaN;
        bench.report(`${what} ${isovalue}`, "level 0", "bytes", bytes, { atMost: most });
      }
      if (rate) {
        const rates = report.megavoxels_per_second;
        bench.report(what, "rate", "Mvoxel/s", rates, { atLeast: rate });
        if (name) bunnyRate = median(rates);
      }
    }
    await buildLarge(bench, tool, bunnyRate);
  },
} satisfies Benchmark;
