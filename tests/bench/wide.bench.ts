// Building stores of volumes with large slices within --memory 1G: the rate relative to that of the
// bunny, whose layers fit, and the peak memory.
import { writeFileSync } from "node:fs";
import { join } from "node:path";
import type { Bench, Benchmark } from "./harness/benchmark.ts";
import { readNrrd } from "./harness/flying_edges.ts";

const megabytes = 1024;

/** The slices of the wide volumes: one layer of blocks, or all with ISOSPLAT_BENCH_WIDE=full. */
const isFull = process.env.ISOSPLAT_BENCH_WIDE === "full";

const volumes = [
  { name: "8192 × 8192", type: "i16", size: [8192, 8192, isFull ? 512 : 66] },
  { name: "20000 × 20000", type: "u8", size: [20000, 20000, isFull ? 200 : 66] },
];

interface Built {
  voxels: number;
  seconds: number;
  processor: number;
  planned: number;
  peak: number;
}

async function build(
  bench: Bench,
  tile: string[],
  type: string,
  size: number[],
): Promise<Built & { rate: number }> {
  const program = join(bench.root, "build/release/tests/bench/build/isosplat_wide_bench");
  const store = join(bench.folder, "wide.isosplat");
  const { stdout } = await bench.command(program, [
    ...tile,
    type,
    ...size.map(String),
    String(megabytes),
    "2",
    store,
  ]);
  const built = JSON.parse(stdout) as Built;
  return { ...built, rate: built.voxels / built.seconds / 1e6 };
}

export default {
  title: "building stores of volumes with large slices within 1 GiB",
  async run(bench) {
    const path = bench.volume("bunny_ct_i16.nrrd");
    if (!path) return;
    const { voxels, data } = readNrrd(path);
    const raw = join(bench.folder, "bunny.raw");
    writeFileSync(raw, data);
    const tile = [raw, ...voxels.map(String)];
    for (const { name, type, size } of volumes) {
      const what = `${name} × ${size[2]}, ${type}`;
      bench.say(what);
      const before = await build(bench, tile, type, voxels);
      const wide = await build(bench, tile, type, size);
      const after = await build(bench, tile, type, voxels);
      const bunny = (before.rate + after.rate) / 2;
      bench.report(what, "rate", "Mvoxel/s", wide.rate);
      bench.report(what, "rate of the bunny", "Mvoxel/s", [before.rate, after.rate]);
      bench.report(what, "rate / rate of the bunny", "", wide.rate / bunny, { atLeast: 0.6 });
      const each = (built: Built) => built.processor / built.voxels;
      const ratio = (each(before) + each(after)) / 2 / each(wide);
      bench.report(what, "processor time of a voxel, the bunny's / this volume's", "", ratio);
      bench.report(what, "planned memory", "MiB", wide.planned);
      bench.report(what, "peak memory", "MiB", wide.peak, { atMost: megabytes });
    }
  },
} satisfies Benchmark;
