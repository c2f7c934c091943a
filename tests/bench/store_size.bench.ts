// The sizes of stores and of one isovalue, compared with volumes that are compressed as a whole.
import { existsSync, statSync } from "node:fs";
import { join } from "node:path";
import type { Benchmark } from "./harness/benchmark.ts";

const volumes = [
  "chris_t1.nii.gz",
  "eun_brain.nii.gz",
  "mni152.nii.gz",
  "mr_t1_dicom",
  "CT_AVM.nii.gz",
  "ct_shear.nii.gz",
  "engine.nhdr",
  "bonsai.nhdr",
  "aneurysm.nhdr",
  "lobster.nhdr",
  "bunny_ct_i16.nrrd",
  "statueLeg.nhdr",
];

interface Report {
  raw_bytes: number;
  store_bytes: number;
  coarse_bytes: number;
  isovalue_bytes: number;
  isovalue_bytes_of_level_0: number;
  isovalue_bytes_by_active_cells: number;
  fetched_cells_per_active_cell: number;
  whole_bytes: number;
}

export default {
  title: "stores: size and bytes of an isovalue, beside the volume compressed whole",
  async run(bench) {
    const tool = join(bench.root, "build/release/tests/bench/build/isosplat_store_size_bench");
    if (!existsSync(tool)) throw new Error(`${tool} is not built: npm run build`);
    const zstd = bench.program("zstd");
    for (const volume of volumes) {
      const path = bench.volume(volume);
      if (!path) continue;
      const what = volume.replace(/\..*/, "");
      bench.say(what);
      const quantizedValues = join(bench.folder, `${what}.raw`);
      const { stdout } = await bench.command(tool, [path, "--quantized-values", quantizedValues]);
      const report = JSON.parse(stdout) as Report;
      const raw = report.raw_bytes;
      bench.report(what, "store / raw", "", report.store_bytes / raw, { atMost: 1 });
      bench.report(what, "coarse levels / raw", "", report.coarse_bytes / raw);
      bench.report(what, "mean isovalue", "bytes", report.isovalue_bytes);
      bench.report(what, "mean isovalue, level 0", "bytes", report.isovalue_bytes_of_level_0);
      bench.report(
        what,
        "mean isovalue by active cells",
        "bytes",
        report.isovalue_bytes_by_active_cells,
      );
      bench.report(what, "cells fetched / active", "", report.fetched_cells_per_active_cell);
      bench.report(what, "whole, our predictor", "bytes", report.whole_bytes);
      if (!zstd) continue;
      const packed = `${quantizedValues}.zst`;
      await bench.command(zstd, ["-19", "-q", "-f", "--rm", quantizedValues, "-o", packed]);
      bench.report(what, "whole, zstd -19", "bytes", statSync(packed).size);
    }
  },
} satisfies Benchmark;
