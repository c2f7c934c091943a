// The parts of a build by several ranks: the processor time and the messages of each, in one thread.
// docs/scale.md computes from them how many ranks a build can use.
import { existsSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import type { Benchmark } from "./harness/benchmark.ts";
import { readNrrd } from "./harness/flying_edges.ts";

interface Parts {
  read: number;
  send: number;
  encode: number;
  receive: number;
  taskMB: number;
  encodedMB: number;
}

interface Measured {
  begin: number;
  finest: Parts;
  coarser: Parts;
  voxels: number;
}

export default {
  title: "the parts of a build by several ranks",
  async run(bench) {
    const path = bench.volume("bunny_ct_i16.nrrd");
    if (!path) return;
    const program = join(bench.root, "build/release/tests/bench/build/isosplat_rank_parts_bench");
    if (!existsSync(program)) {
      bench.skip("parts", "not built (.ci/build benchmarks)");
      return;
    }
    const { voxels, data } = readNrrd(path);
    const raw = join(bench.folder, "bunny.raw");
    writeFileSync(raw, data);
    const runs: Measured[] = [];
    for (let run = 0; run < bench.runs; ++run) {
      const { stdout } = await bench.command(program, [raw, ...voxels.map(String)]);
      runs.push(JSON.parse(stdout) as Measured);
    }
    const count = runs[0]?.voxels ?? Number.NaN;
    bench.report("bunny", "voxels", "million", count / 1e6);
    const perVoxel = (of: (run: Measured) => number) =>
      runs.map((run) => (1e9 * of(run)) / run.voxels);
    bench.report(
      "bunny",
      "range and sample",
      "ns/voxel",
      perVoxel((run) => run.begin),
    );
    for (const level of ["finest", "coarser"] as const) {
      const what = `bunny, ${level === "finest" ? "level 0" : "coarser levels"}`;
      for (const part of ["read", "send", "encode", "receive"] as const) {
        bench.report(
          what,
          part,
          "ns/voxel",
          perVoxel((run) => run[level][part]),
        );
      }
      const bytes = (part: "taskMB" | "encodedMB") => ((runs[0]?.[level][part] ?? 0) * 1e6) / count;
      bench.report(what, "tasks", "bytes/voxel", bytes("taskMB"));
      bench.report(what, "encoded blocks", "bytes/voxel", bytes("encodedMB"));
    }
  },
} satisfies Benchmark;
