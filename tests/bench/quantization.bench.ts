// The effect of --max-error on the bytes of a store of floating-point numbers, and of one isovalue.
import { readdirSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import type { Bench, Benchmark } from "./harness/benchmark.ts";
import { imageData } from "./harness/image_data.ts";

/** Values of --max-error relative to the volume's range. 0: the precision of 16 bits. */
const shares = [0, 1e-4, 1e-3, 4e-3];

interface Report {
  range: [number, number];
  voxels: [number, number, number];
  fileBytes: number;
  mapping: { maxError: number; bits: number };
  chunkReport: { queries: { bytes: number; activeCells: number }[] };
}

/** Converts VTK image data to a raw volume whose name contains size and type. */
function rawOf(bench: Bench, image: string, name: string): string {
  const raw = join(bench.folder, `${name}_64x64x64_f32.raw`);
  writeFileSync(raw, imageData(image));
  return raw;
}

function volumes(bench: Bench): [string, string][] {
  const found: [string, string][] = [];
  const add = (name: string, path: string | undefined) => path && found.push([name, path]);
  add("fetal_atlas", bench.volume("fetal_atlas_f32.nrrd"));
  const hydrogen = bench.volume("hydrogen_f32.vti");
  if (hydrogen) add("hydrogen", rawOf(bench, hydrogen, "hydrogen"));
  const fingers = bench.volume("viscous_fingers");
  if (fingers) {
    const last = readdirSync(fingers).sort().at(-1) as string;
    add("viscous_fingers", rawOf(bench, join(fingers, last), "fingers"));
  }
  return found;
}

export default {
  title: "floating-point volumes: what a greater --max-error saves",
  quick: true,
  async run(bench) {
    for (const [name, volume] of volumes(bench)) {
      let range = 0;
      for (const share of shares) {
        const store = join(bench.folder, `${name}.isosplat`);
        const options = share > 0 ? ["--max-error", String(share * range)] : [];
        await bench.command(bench.isosplat, ["build", volume, "-o", store, ...options]);
        const { stdout } = await bench.command(bench.isosplat, [
          "info",
          store,
          "--chunks",
          "--json",
        ]);
        const { mapping, chunkReport, ...report } = JSON.parse(stdout) as Report;
        range ||= report.range[1] - report.range[0];
        const what = `${name} ${share > 0 ? `±${share * 100} %` : "16 bits"}`;
        const queries = chunkReport.queries.filter(({ activeCells }) => activeCells > 0);
        const mean = queries.reduce((sum, { bytes }) => sum + bytes, 0) / queries.length;
        bench.report(what, "greatest error", "", mapping.maxError);
        bench.report(what, "bits", "", mapping.bits);
        const [x, y, z] = report.voxels;
        bench.report(what, "store / raw", "", report.fileBytes / (4 * x * y * z));
        bench.report(what, "one isovalue, mean", "bytes", mean);
      }
    }
  },
} satisfies Benchmark;
