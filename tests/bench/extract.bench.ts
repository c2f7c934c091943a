import { type ChildProcess, spawn } from "node:child_process";
import { existsSync } from "node:fs";
import { join } from "node:path";
import { createInterface } from "node:readline";
import type { Bench, Benchmark } from "./harness/benchmark.ts";
import { FlyingEdges, type Mesh, readNrrd } from "./harness/flying_edges.ts";
import { root } from "./harness/paths.ts";
import { peakMegabytes } from "./harness/peak_memory.ts";

const threads = 2;
const cases = [
  { file: "engine.nhdr", isovalue: 60.5 },
  { file: "bonsai.nhdr", isovalue: 40.5 },
  { file: "bunny_ct_i16.nrrd", isovalue: 1000.5 },
];

interface Extraction {
  seconds: number;
  chunks: number;
  samples: number;
  /** Bytes of the samples in the GPU's layout. */
  bytes: number;
  /** Bytes read from the store. */
  read: number;
}

interface Points {
  seconds: number;
  points: number;
  bytes: number;
}

interface Triangles {
  seconds: number;
  vertices: number;
  triangles: number;
  bytes: number;
}

/** A separate process with an open store, which extracts points, or a mesh, on request. */
class StoreExtractor<Answer> {
  readonly #child: ChildProcess;
  readonly #lines: AsyncIterator<string>;

  constructor(program: string, store: string, ...options: string[]) {
    const args = [store, String(threads), ...options];
    const child = spawn(program, args, { stdio: ["pipe", "pipe", "inherit"] });
    this.#child = child;
    this.#lines = createInterface({ input: child.stdout })[Symbol.asyncIterator]();
  }

  get peakMegabytes(): number {
    return peakMegabytes(this.#child.pid);
  }

  async extract(isovalue: number): Promise<Answer> {
    this.#child.stdin?.write(`${isovalue}\n`);
    const { value, done } = await this.#lines.next();
    if (done) throw new Error("isosplat_extract_bench ended");
    return JSON.parse(value) as Answer;
  }

  close(): void {
    this.#child.kill();
  }
}

function median(values: number[]): number {
  const sorted = [...values].sort((a, b) => a - b);
  return sorted[Math.floor(sorted.length / 2)] ?? 0;
}

async function runCase(bench: Bench, program: string, python: string | undefined, index: number) {
  const { file, isovalue } = cases[index] as (typeof cases)[number];
  const volume = bench.volume(file);
  if (!volume) return;
  const what = `${file.replace(/\..*/, "")} ${isovalue}`;
  const store = `${bench.folder}/${index}.isosplat`;
  bench.say(`building the store of ${file}`);
  await bench.command(bench.isosplat, ["build", volume, "-o", store, "--quiet"]);
  const ours = new StoreExtractor<Extraction>(program, store);
  const mesher = new StoreExtractor<Triangles>(program, store, "mesh");
  // With the normals of their cells, as the points of a mesh would be without their neighbours, and with smooth
  // ones, which need the sums of all cells around each lattice point.
  const points = new StoreExtractor<Points>(program, store, "points");
  const smooth = new StoreExtractor<Points>(program, store, "smooth_points");
  const peer = python
    ? await FlyingEdges.open(python, readNrrd(volume), threads, bench.folder)
    : undefined;
  try {
    let extraction: Extraction | undefined;
    let triangles: Triangles | undefined;
    let mesh: Mesh | undefined;
    // The two programs alternate. Of two extractions in a row, the first warms the caches, and only the
    // second is measured.
    const runs = await bench.interleave(
      {
        isosplat: async () => {
          await ours.extract(isovalue);
          extraction = await ours.extract(isovalue);
          return 1000 * extraction.seconds;
        },
        mesh: async () => {
          await mesher.extract(isovalue);
          triangles = await mesher.extract(isovalue);
          return 1000 * triangles.seconds;
        },
        points: async () => {
          await points.extract(isovalue);
          return 1000 * (await points.extract(isovalue)).seconds;
        },
        smooth: async () => {
          await smooth.extract(isovalue);
          return 1000 * (await smooth.extract(isovalue)).seconds;
        },
        vtk: async () => {
          if (!peer) return 0;
          await peer.extract(isovalue);
          mesh = await peer.extract(isovalue);
          return 1000 * mesh.seconds;
        },
      },
      3 * bench.runs,
    );
    if (!extraction) return;
    bench.report(what, "Isosplat, 2 threads", "ms", runs.isosplat);
    bench.report(what, "samples decoded", "", extraction.samples);
    bench.report(what, "output", "MB", extraction.bytes / 1e6);
    bench.report(what, "read from the store", "KB", extraction.read / 1e3);
    bench.report(what, "Isosplat, points with the normals of their cells", "ms", runs.points);
    bench.report(what, "Isosplat, points with smooth normals", "ms", runs.smooth);
    if (triangles) {
      bench.report(what, "Isosplat, mesh", "ms", runs.mesh);
      bench.report(what, "triangles of the mesh", "", triangles.triangles);
      bench.report(what, "peak memory of the mesh", "MB", mesher.peakMegabytes);
    }
    if (!mesh) return;
    bench.report(what, "Flying Edges, 2 threads (TBB)", "ms", runs.vtk);
    bench.report(what, "its triangles", "", mesh.triangles);
    bench.report(what, "its output", "MB", mesh.bytes / 1e6);
    bench.report(what, "faster by", "×", median(runs.vtk) / median(runs.isosplat), { atLeast: 3 });
    bench.report(what, "output, of its", "×", extraction.bytes / mesh.bytes, { atMost: 1 / 3 });
    const pointsRatio = median(runs.vtk) / median(runs.points);
    bench.report(what, "points with the normals of their cells faster by", "×", pointsRatio);
    const smoothRatio = median(runs.vtk) / median(runs.smooth);
    bench.report(what, "points with smooth normals faster by", "×", smoothRatio);
    const meshRatio = median(runs.vtk) / median(runs.mesh);
    bench.report(what, "mesh faster by", "×", meshRatio, { atLeast: 1.5 });
    if (!peer) return;
    const memory = mesher.peakMegabytes / peer.peakMegabytes;
    bench.report(what, "peak memory of the mesh, of its", "×", memory, { atMost: 0.5 });
  } finally {
    ours.close();
    mesher.close();
    points.close();
    smooth.close();
    peer?.close();
  }
}

export default {
  title:
    "extraction beside VTK's Flying Edges: until samples can be drawn, and until there is a mesh",
  quick: true,
  async run(bench) {
    const program = join(root, "build/release/tests/bench/extract/isosplat_extract_bench");
    if (!existsSync(program)) throw new Error(`${program} is not built. Run: npm run build`);
    const python = bench.pythonWithVtk();
    for (let i = 0; i < cases.length; ++i) await runCase(bench, program, python, i);
  },
} satisfies Benchmark;
