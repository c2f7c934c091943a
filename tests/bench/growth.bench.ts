// Growth with the number of voxels: of building, the store, its directory, the bytes for an
// isovalue and a view, and extraction. docs/scale.md has the exponents, and their consequences for
// large volumes.
import {
  closeSync,
  openSync,
  readSync,
  rmSync,
  statSync,
  truncateSync,
  writeFileSync,
} from "node:fs";
import { join } from "node:path";
import { type Core, loadCore, maxHeaderBytes } from "../../web/core/index.ts";
import { serve } from "../browser/support/server.ts";
import { type Fetched, visit } from "./growth/client.ts";
import { enlarge, nrrdOf } from "./growth/enlarge.ts";
import type { Bench, Benchmark } from "./harness/benchmark.ts";
import { readNrrd } from "./harness/flying_edges.ts";
import { measureUse } from "./harness/processor.ts";

/** A volume in one of several sizes. */
interface Case {
  name: string;
  voxels: number;
  isovalue: number;
  /** Writes the volume's file. */
  write(path: string): Promise<void> | void;
}

/**
 * A small picture, whose cells are smaller than its pixels even for moderate volumes, and a usual
 * one.
 */
const pictures = [
  { pixels: [128, 96], runs: 3 },
  { pixels: [1024, 768], runs: 1 },
] as const;

/** Measures the figures in a store's header (shared/core/store/FORMAT.md). */
function measureStore(bench: Bench, core: Core, { name, isovalue }: Case, path: string): void {
  const bytes = statSync(path).size;
  const head = Buffer.alloc(Math.min(maxHeaderBytes, bytes));
  const file = openSync(path, "r");
  readSync(file, head, 0, head.length, 0);
  closeSync(file);
  const store = core.openStore(head);
  const pages = store.pages().reduce((sum, page) => sum + page.bytes, 0);
  const active = store.info.metadata.active_cells;
  store.close();
  if (!active) throw new Error(`${name}: expected a table of active cells in the store`);
  // Counts are exact at the middle of a bin: for bytes, at the integers.
  const { low, high, counts } = active;
  const bin = Math.floor(((isovalue - low) / (high - low)) * counts.length);
  bench.report(name, "active cells", "million", (counts[bin] ?? 0) / 1e6);
  bench.report(name, "store", "MB", bytes / 1e6);
  bench.report(name, "directory pages", "KB", pages / 1e3);
}

/** Extracts an isovalue repeatedly. The time to open the store is subtracted. */
async function measureExtraction(bench: Bench, { name, isovalue, voxels }: Case, store: string) {
  const program = join(bench.root, "build/release/tests/bench/extract/isosplat_extract_bench");
  const again = Math.round(Math.min(100, Math.max(3, 1e8 / voxels)));
  const extract = (times: number) =>
    measureUse(bench, program, [store, "1"], `${isovalue}\n`.repeat(times));
  const milliseconds: number[] = [];
  for (let run = 0; run < Math.min(bench.runs, 3); ++run) {
    const once = await extract(1);
    const often = await extract(1 + again);
    milliseconds.push((1e3 * (often.processorSeconds - once.processorSeconds)) / again);
    if (run > 0) continue;
    const { samples, read, chunks } = JSON.parse(once.stdout) as Record<string, number>;
    bench.report(name, "cells of the isovalue's chunks", "million", (samples ?? 0) / 1e6);
    bench.report(name, "isovalue, level 0", "KB", (read ?? 0) / 1e3);
    bench.report(name, "isovalue, level 0", "chunks", chunks ?? 0);
  }
  bench.report(name, "extraction, processor time", "ms", milliseconds);
}

async function measureBuild(bench: Bench, { name, voxels }: Case, file: string, store: string) {
  const runs = Math.min(bench.runs, voxels > 1e8 ? 3 : 5);
  const seconds: number[] = [];
  const megabytes: number[] = [];
  const options = ["--no-thumbnail", "--quiet", "--force"];
  for (let run = 0; run < runs; ++run) {
    const used = await measureUse(bench, bench.isosplat, ["build", file, "-o", store, ...options]);
    seconds.push(used.processorSeconds);
    megabytes.push(used.peakBytes / 1e6);
  }
  bench.report(name, "build, processor time", "s", seconds);
  bench.report(name, "build, peak memory", "MB", megabytes);
}

/** Measures the bytes that the client fetches from the real server. */
async function measureFetches(bench: Bench, core: Core, { name, isovalue }: Case, store: string) {
  const server = await serve([store]);
  const first: number[] = [];
  try {
    for (const { pixels, runs } of pictures) {
      const visits: Fetched[] = [];
      for (let run = 0; run < runs; ++run) {
        visits.push(await visit(core, server.url, "growth", isovalue, pixels));
      }
      first.push(...visits.map(({ firstBytes }) => firstBytes / 1e3));
      const size = pixels.join(" × ");
      const complete = `until complete, ${size}`;
      bench.report(
        name,
        complete,
        "KB",
        visits.map(({ bytes }) => bytes / 1e3),
      );
      bench.report(
        name,
        complete,
        "requests",
        visits.map(({ requests }) => requests),
      );
      bench.report(
        name,
        `finest level, ${size}`,
        "",
        visits.map(({ finestLevel }) => finestLevel),
      );
    }
  } finally {
    await server.stop();
  }
  bench.report(name, "until the first surface", "KB", first);
}

async function measure(bench: Bench, core: Core, one: Case): Promise<void> {
  bench.say(one.name);
  const file = join(bench.folder, "growth.nrrd");
  const store = join(bench.folder, "growth.isosplat");
  await one.write(file);
  bench.report(one.name, "voxels", "million", one.voxels / 1e6);
  bench.report(one.name, "file", "MB", statSync(file).size / 1e6);
  await measureBuild(bench, one, file, store);
  rmSync(file);
  measureStore(bench, core, one, store);
  await measureExtraction(bench, one, store);
  await measureFetches(bench, core, one, store);
  rmSync(store);
}

/** Volumes with structure at all scales, which a program of the benchmark generates. */
function generated(bench: Bench, kind: string, isovalue: number, size: number): Case {
  const program = join(bench.root, "build/release/tests/bench/growth/isosplat_growth_volume");
  return {
    name: `${kind} ${size}³`,
    voxels: size ** 3,
    isovalue,
    write: async (path) => void (await bench.command(program, [kind, String(size), path])),
  };
}

/** A real volume with fewer voxels, with its own number of voxels, and with more. */
function enlarged(bench: Bench, factor: number): Case[] {
  const path = bench.volume("engine.nhdr");
  if (!path) return [];
  const volume = readNrrd(path);
  const voxels = volume.voxels.reduce((product, n) => product * Math.round(n * factor), 1);
  const write = (to: string) => writeFileSync(to, nrrdOf(enlarge(volume, factor)));
  return [{ name: `engine × ${factor}`, voxels, isovalue: 60, write }];
}

/** The memory that a build requires before it reads a volume. The volume here is a sparse file. */
async function measureLeastMemory(bench: Bench): Promise<void> {
  const voxels = [10240, 7680, 1536];
  const file = join(bench.folder, "huge.raw");
  writeFileSync(file, "");
  truncateSync(
    file,
    voxels.reduce((bytes, n) => bytes * n, 8),
  );
  const options = ["--dims", voxels.join("x"), "--type", "f64", "--memory", "64M"];
  // Otherwise the build first searches slices of the file for a fill value.
  options.push("--missing-value", "none");
  const store = join(bench.folder, "huge.isosplat");
  const refusal = await bench
    .command(bench.isosplat, ["build", file, "-o", store, ...options])
    .then(
      () => "no refusal",
      (error: Error) => error.message,
    );
  rmSync(file);
  const [, mebibytes] = /at least (\d+) MiB/.exec(refusal) ?? [];
  if (!mebibytes) throw new Error(`expected the memory that a build needs, found: ${refusal}`);
  bench.report(`${voxels.join(" × ")} f64`, "least memory of a build", "MiB", Number(mebibytes));
}

export default {
  title: "growth with the number of voxels: building, store, fetches, extraction",
  async run(bench) {
    const core = await loadCore();
    const most = Number(process.env.ISOSPLAT_BENCH_GROWTH ?? 512);
    if (!(most >= 128)) throw new Error("ISOSPLAT_BENCH_GROWTH: expected a size of at least 128");
    const sizes = [64, 128, 256, 512, 1024, 2048].filter((size) => size <= most);
    // The turbulence has doubles: one of 2048³ would take 69 GB.
    const ofDoubles = sizes.filter((size) => size <= 1024);
    const cases = [
      ...sizes.map((size) => generated(bench, "fractal", 226, size)),
      ...ofDoubles.map((size) => generated(bench, "turbulence", 0, size)),
      ...[0.5, 1, 2].flatMap((factor) => enlarged(bench, factor)),
    ];
    for (const one of cases) await measure(bench, core, one);
    core.close();
    await measureLeastMemory(bench);
  },
} satisfies Benchmark;
