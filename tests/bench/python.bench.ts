// The package for Python against the program: building a store from an array, points of an
// isosurface as arrays, and the time of an import.
import { execFileSync, spawnSync } from "node:child_process";
import { existsSync, readFileSync } from "node:fs";
import { join } from "node:path";
import type { Bench, Benchmark } from "./harness/benchmark.ts";
import { Worker } from "./python/worker.ts";

const python = "/usr/bin/python3";

/** The seconds of a command. */
function timeCommand(command: string, ...args: string[]): number {
  const begin = performance.now();
  execFileSync(command, args);
  return (performance.now() - begin) / 1000;
}

/** The seconds of a statement in a new Python, as the statement's own process measures them. */
function timeStatement(statement: string, folder: string): number {
  const code = `import time\nbegin = time.perf_counter()\n${statement}\nprint(time.perf_counter() - begin)`;
  const run = spawnSync(python, ["-c", code], {
    encoding: "utf8",
    env: { ...process.env, PYTHONPATH: folder },
  });
  if (run.status !== 0) throw new Error(run.stderr);
  return Number(run.stdout);
}

/** The chunks of a store. Header and pages depend on the length of the volume's name. */
function chunks(bench: Bench, path: string): Buffer {
  const info = execFileSync(bench.isosplat, ["info", "--json", "--chunks", path], {
    encoding: "utf8",
    maxBuffer: 1 << 26,
  });
  const { chunkReport } = JSON.parse(info) as { chunkReport: { levels: { bytes: number }[] } };
  const size = chunkReport.levels.reduce((sum, { bytes }) => sum + bytes, 0);
  const bytes = readFileSync(path);
  const begin = bytes.readUInt32LE(12); // header_bytes: FORMAT.md
  return bytes.subarray(begin, begin + size);
}

async function compareWork(bench: Bench, folder: string): Promise<void> {
  const what = "512³ uint16";
  const file = join(bench.folder, "volume.npy");
  const ours = join(bench.folder, "python.isosplat");
  const theirs = join(bench.folder, "program.isosplat");
  const points = join(bench.folder, "points.npy");
  const worker = new Worker(python, folder, join(bench.root, "tests/bench/python/worker.py"));
  await worker.ask("make", file);
  const build = ["--threads", "2", "--no-thumbnail", "-q", "--force"];
  const isovalue = await worker.ask("build", ours).then(() => worker.ask("isovalue"));
  const seconds = await bench.interleave({
    buildPython: () => worker.ask("build", ours),
    buildProgram: () => timeCommand(bench.isosplat, "build", file, "-o", theirs, ...build),
    pointsPython: () => worker.ask("points", String(isovalue)),
    pointsProgram: () =>
      timeCommand(
        bench.isosplat,
        ...["extract", theirs, "-i", String(isovalue), "--threads", "2", "-o", points, "--force"],
      ),
  });
  worker.close();
  const isSame = chunks(bench, ours).equals(chunks(bench, theirs));
  bench.report(what, "same chunks as the program's", "", isSame ? 1 : 0, { atLeast: 1 });
  const ratios = (a: number[], b: number[]) => a.map((each, i) => each / (b[i] ?? Number.NaN));
  bench.report(what, "build, an array in memory", "s", seconds.buildPython);
  bench.report(
    what,
    "rate of build, array / the program's whole command",
    "",
    ratios(seconds.buildProgram, seconds.buildPython),
    { atLeast: 0.95 },
  );
  bench.report(what, "points of an isosurface", "s", seconds.pointsPython);
  bench.report(
    what,
    "rate of points, arrays / isosplat extract to .npy",
    "",
    ratios(seconds.pointsProgram, seconds.pointsPython),
    { atLeast: 0.9 },
  );
}

export default {
  title: "the package for Python, against the program",
  async run(bench) {
    const folder = join(bench.root, "build/release/native/python/package");
    if (!existsSync(folder)) {
      bench.skip("Python", "not built (.ci/install-packages --for test; npm run build)");
      return;
    }
    const imports = await bench.interleave({
      package: () => timeStatement("import isosplat", folder) * 1000,
      use: () => timeStatement("import isosplat\nisosplat.build", folder) * 1000,
      numpy: () => timeStatement("import numpy", folder) * 1000,
    });
    bench.report("import", "import isosplat", "ms", imports.package, { atMost: 60 });
    bench.report("import", "import isosplat, until the first use", "ms", imports.use);
    bench.report("import", "import numpy", "ms", imports.numpy);
    await compareWork(bench, folder);
  },
} satisfies Benchmark;
