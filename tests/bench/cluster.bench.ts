// Building a store with the processes of an MPI job: the rate and the memory relative to one process
// with as many threads, and whether the stores are the same.
import { existsSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import type { Bench, Benchmark } from "./harness/benchmark.ts";
import { readNrrd } from "./harness/flying_edges.ts";
import { peakMegabytes } from "./harness/peak_memory.ts";
import { median } from "./harness/results.ts";

interface Build {
  /** Million voxels per second, from the time at which all processes have opened the volume. */
  rate: number;
  /** Of the whole command, with the start of mpirun and writing to the disk. */
  seconds: number;
  /** Processor time of all processes, with the start of mpirun, in seconds. */
  processor: number;
  /** The largest peak memory of a process, MB. */
  peak: number;
  store: Buffer;
}

/** Runs a command that builds `store`, and measures the peak memory of its processes. */
async function build(bench: Bench, command: string[], store: string): Promise<Build> {
  const begin = performance.now();
  // Open MPI refuses to run as root otherwise, as in containers.
  const child = bench.start("sh", ["-c", '"$@" && times >&2', "sh", ...command], {
    OMPI_ALLOW_RUN_AS_ROOT: "1",
    OMPI_ALLOW_RUN_AS_ROOT_CONFIRM: "1",
  });
  let peak = 0;
  const poll = setInterval(() => {
    for (const pid of descendants(child.pid)) {
      try {
        peak = Math.max(peak, peakMegabytes(pid));
      } catch {
        // It has ended.
      }
    }
  }, 5);
  let text = "";
  child.stdout?.on("data", (data: Buffer) => {
    text += data.toString();
  });
  let errors = "";
  child.stderr?.on("data", (data: Buffer) => {
    errors += data.toString();
  });
  const code = await new Promise((resolve) => child.on("close", resolve));
  clearInterval(poll);
  const rate = /\((\d+) million voxels\/s\)/.exec(text)?.[1];
  if (code !== 0 || !rate) throw new Error(`${command.join(" ")}: exit status ${code}\n${errors}`);
  const seconds = (performance.now() - begin) / 1000;
  return {
    rate: Number(rate),
    seconds,
    processor: processorTime(errors),
    peak,
    store: readFileSync(store),
  };
}

/** The processor time of ended children, from the last line of a shell's `times`. */
function processorTime(text: string): number {
  const parts =
    text
      .trim()
      .split("\n")
      .at(-1)
      ?.match(/(\d+)m([\d.]+)s/g) ?? [];
  return parts.reduce((sum, part) => {
    const [minutes, seconds] = part.split("m");
    return sum + Number(minutes) * 60 + Number.parseFloat(seconds ?? "");
  }, 0);
}

/** The processes that a process has started, and those that these have started. */
function descendants(pid: number | undefined): number[] {
  try {
    const list = readFileSync(`/proc/${pid}/task/${pid}/children`, "utf8").trim();
    const children = list === "" ? [] : list.split(" ").map(Number);
    return [...children, ...children.flatMap(descendants)];
  } catch {
    return [];
  }
}

async function compare(bench: Bench, what: string, path: string, mpi: string): Promise<void> {
  bench.say(what);
  const store = join(bench.folder, `${what.replace(/\W+/g, "_")}.isosplat`);
  const builds: Record<string, Build[]> = {};
  const run = (name: string, command: string[], threads: number) => async () => {
    const args = ["build", path, "-o", store, "--no-thumbnail", "--threads", String(threads)];
    const built = await build(bench, [...command, ...args], store);
    builds[name] ??= [];
    builds[name].push(built);
    return built.rate;
  };
  const threads = (count: number) => run(`threads${count}`, [bench.isosplat], count);
  const mpirun = ["mpirun", "--oversubscribe", "--bind-to", "none", "-n"];
  const ranks = (count: number) => run(`ranks${count}`, [...mpirun, String(count), mpi], 1);
  const rates = await bench.interleave({
    threads1: threads(1),
    ranks1: ranks(1),
    threads2: threads(2),
    ranks2: ranks(2),
    ranks4: ranks(4),
    ranks7: ranks(7),
  });
  const of = (name: string, part: "seconds" | "processor" | "peak") =>
    (builds[name] ?? []).map((b) => b[part]);
  const first = builds.threads2?.[0]?.store ?? Buffer.alloc(0);
  const isSame = Object.values(builds)
    .flat()
    .every((built) => Buffer.compare(built.store, first) === 0);
  bench.report(what, "same bytes as one process's", "", isSame ? 1 : 0, { atLeast: 1 });
  bench.report(what, "rate, one process, 2 threads", "Mvoxel/s", rates.threads2);
  bench.report(what, "rate, 2 ranks", "Mvoxel/s", rates.ranks2);
  const ratio = (a: number[], b: number[]) => median(a) / median(b);
  bench.report(what, "rate, 2 ranks / 2 threads", "", ratio(rates.ranks2, rates.threads2), {
    atLeast: 0.85,
  });
  bench.report(what, "rate, 1 rank / 1 thread", "", ratio(rates.ranks1, rates.threads1));
  bench.report(
    what,
    "rate, 4 ranks on 2 cores / 2 threads",
    "",
    ratio(rates.ranks4, rates.threads2),
  );
  bench.report(
    what,
    "rate, 7 ranks on 2 cores / 2 threads",
    "",
    ratio(rates.ranks7, rates.threads2),
  );
  const commands = ratio(of("threads2", "seconds"), of("ranks2", "seconds"));
  bench.report(what, "speed of the whole command, 2 ranks / 2 threads", "", commands);
  const processor = ratio(of("threads2", "processor"), of("ranks2", "processor"));
  bench.report(what, "processor time, one process / 2 ranks", "", processor);
  const best = Math.max(...rates.ranks2) / Math.max(...rates.threads2);
  bench.report(what, "rate, 2 ranks / 2 threads, the best run of each", "", best);
  const peak = ratio(of("ranks2", "peak"), of("threads2", "peak"));
  bench.report(what, "peak memory of one process", "MB", of("threads2", "peak"));
  bench.report(what, "peak memory, a rank of 2 / one process", "", peak, { atMost: 1.15 });
}

export default {
  title: "building stores with several processes (MPI), against one",
  async run(bench) {
    const mpi = join(bench.root, "build/release/native/mpi/isosplat-mpi");
    if (!existsSync(mpi)) {
      bench.skip(
        "MPI",
        "isosplat-mpi is not built (.ci/install-packages --for test; npm run build)",
      );
      return;
    }
    const path = bench.volume("bunny_ct_i16.nrrd");
    if (!path) return;
    // The file is compressed. Each rank decompresses all of it, but reads its part of a raw file.
    const { voxels, data } = readNrrd(path);
    const raw = join(bench.folder, "bunny.nrrd");
    const header = `NRRD0004\ntype: int16\ndimension: 3\nsizes: ${voxels.join(" ")}\nendian: little\nencoding: raw\n\n`;
    writeFileSync(raw, Buffer.concat([Buffer.from(header), data]));
    await compare(bench, "bunny, raw", raw, mpi);
    await compare(bench, "bunny, gzip", path, mpi);
  },
} satisfies Benchmark;
