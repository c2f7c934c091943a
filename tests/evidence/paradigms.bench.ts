// Repeats the paper's experiment (section 6, figure 6). It compares the paradigms (A) to (D) and
// marching cubes with an interval tree, composed of the core's functions, with VTK's marching cubes
// and Flying Edges. All run on one thread, with 16 isovalues spread over the range of each volume,
// and 10 runs of each.
import { existsSync, mkdirSync, rmSync } from "node:fs";
import { join } from "node:path";
import type { Bench, Benchmark } from "../bench/harness/benchmark.ts";
import { FlyingEdges, readNrrd } from "../bench/harness/flying_edges.ts";
import { median } from "../bench/harness/results.ts";

const volumes = [
  "engine.nhdr",
  "lobster.nhdr",
  "aneurysm.nhdr",
  "BostonTeapot.nhdr",
  "bunny_ct_i16.nrrd",
  "bucky.nrrd",
];
const paradigms = ["a", "b", "c", "d", "mc"] as const;
const isovalueCount = 16;
const runs = Number(process.env.ISOSPLAT_BENCH_RUNS ?? 10);
const wanted = process.env.ISOSPLAT_BENCH_PARADIGMS ?? "";

const label: Record<string, string> = {
  a: "(A) project at extraction",
  b: "(B) as shipped",
  c: "(C) sample and project at extraction",
  d: "(D) sample at extraction",
  mc: "marching cubes, interval tree",
  "marching-cubes": "vtkMarchingCubes",
  "flying-edges": "vtkFlyingEdges3D",
};

interface Row {
  isovalue: number;
  seconds: number[];
  active: number;
  bytes: number;
}

interface Result {
  rows: Row[];
  /** The bytes that preprocessing made: of the store, or of the interval tree. */
  preparedBytes: number;
  peakBytes: number;
}

/** Midpoints between whole numbers, evenly spread over the range. */
function isovaluesOf([low, high]: [number, number]): number[] {
  const step = (high - low) / isovalueCount;
  return Array.from({ length: isovalueCount }, (_, i) => Math.floor(low + (i + 0.5) * step) + 0.5);
}

async function runParadigm(
  bench: Bench,
  name: string,
  volume: string,
  folder: string,
  isovalues: number[],
): Promise<Result> {
  const program = join(bench.root, "build/release/tests/evidence/paradigms/isosplat_paradigms");
  if (!existsSync(program)) throw new Error(`${program} is not built. Run: npm run build`);
  const args = [volume, name, folder, String(runs), ...isovalues.map(String)];
  const { stdout } = await bench.command(program, args);
  const lines = stdout.trim().split("\n");
  const { prepared, peak } = JSON.parse(lines.pop() ?? "{}") as { prepared: number; peak: number };
  const rows = lines.map((line) => JSON.parse(line) as Row);
  return { rows, preparedBytes: prepared, peakBytes: peak };
}

async function runVtk(
  python: string,
  filter: "flying-edges" | "marching-cubes",
  volume: string,
  folder: string,
  isovalues: number[],
): Promise<Result> {
  const peer = await FlyingEdges.open(python, readNrrd(volume), 1, folder, filter);
  try {
    const rows: Row[] = [];
    for (const isovalue of isovalues) {
      let mesh = await peer.extract(isovalue);
      const seconds: number[] = [];
      for (let run = 0; run < runs; ++run) {
        mesh = await peer.extract(isovalue);
        seconds.push(mesh.seconds);
      }
      rows.push({ isovalue, seconds, active: 0, bytes: mesh.bytes });
    }
    return { rows, preparedBytes: 0, peakBytes: 1e6 * peer.peakMegabytes };
  } finally {
    peer.close();
  }
}

const sum = (values: number[]) => values.reduce((a, b) => a + b, 0);
/** Of one extraction of each isovalue, in ms: the sum of medians. */
const total = ({ rows }: Result) => 1000 * sum(rows.map(({ seconds }) => median(seconds)));

function report(bench: Bench, volume: string, name: string, result: Result, active: number[]) {
  const what = `${volume}, ${label[name]}`;
  for (const [i, { isovalue, seconds }] of result.rows.entries()) {
    bench.report(
      what,
      `${active[i]} active cells, isovalue ${isovalue}`,
      "ms",
      seconds.map((s) => 1000 * s),
    );
  }
  bench.report(what, "all isovalues", "ms", total(result));
  bench.report(what, "peak memory", "MB", result.peakBytes / 1e6);
  if (result.preparedBytes) bench.report(what, "preprocessed", "MB", result.preparedBytes / 1e6);
}

async function runVolume(bench: Bench, python: string | undefined, file: string) {
  const demo = join(bench.root, "build/demo", file);
  const path = existsSync(demo) ? demo : bench.volume(file);
  if (!path) return;
  const name = file.replace(/\..*/, "");
  const { stdout } = await bench.command(bench.isosplat, ["info", path, "--json"]);
  const isovalues = isovaluesOf((JSON.parse(stdout) as { range: [number, number] }).range);

  const folder = join(bench.folder, name);
  mkdirSync(folder);
  const results: Record<string, Result> = {};
  for (const paradigm of paradigms) {
    bench.say(`${name}: ${label[paradigm]}`);
    results[paradigm] = await runParadigm(bench, paradigm, path, folder, isovalues);
  }
  for (const filter of python ? (["marching-cubes", "flying-edges"] as const) : []) {
    bench.say(`${name}: ${label[filter]}`);
    results[filter] = await runVtk(python as string, filter, path, folder, isovalues);
  }
  rmSync(folder, { recursive: true });
  const active = (results.a as Result).rows.map((row) => row.active);
  for (const [each, result] of Object.entries(results)) report(bench, name, each, result, active);

  const b = results.b as Result;
  const share = (peer: string) => total(b) / total(results[peer] as Result);
  bench.report(name, "time of (B), of marching cubes with an interval tree", "×", share("mc"), {
    atMost: 0.5,
  });
  if (!python) return;
  bench.report(name, "time of (B), of vtkMarchingCubes", "×", share("marching-cubes"), {
    atMost: 0.5,
  });
  bench.report(name, "time of (B), of vtkFlyingEdges3D", "×", share("flying-edges"));
  const memory = (peer: string) => b.peakBytes / (results[peer] as Result).peakBytes;
  bench.report(name, "peak memory of (B), of vtkMarchingCubes", "×", memory("marching-cubes"), {
    atMost: 1,
  });
}

export default {
  title: "the paper's paradigms and marching cubes: time and memory of extractions, one thread",
  async run(bench) {
    const python = bench.pythonWithVtk();
    for (const volume of volumes) {
      if (volume.includes(wanted)) await runVolume(bench, python, volume);
    }
  },
} satisfies Benchmark;
