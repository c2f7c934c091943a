/** The paper's figures 4 and 7, and two isosurfaces, with the present renderer. */
import { copyFileSync } from "node:fs";
import { join } from "node:path";
import type { Bench } from "../harness/benchmark.ts";
import { root } from "../harness/paths.ts";
import { flyingEdgesMesh, renderProgram } from "../harness/render.ts";

const folder = join(root, "docs/pictures");

/** The name of a picture, the volume, and the options of `isosplat render`. */
const drawn: [string, string, string[]][] = [
  ["figure_4_squares", "fuel.nhdr", ["--kind", "quad", "--unprojected"]],
  ["figure_4_planes", "fuel.nhdr", ["--kind", "ellipse", "--unprojected"]],
  ["figure_4_projected", "fuel.nhdr", ["--kind", "exact"]],
  [
    "engine_two_isosurfaces",
    "engine.nhdr",
    ["-i", "60.5,180.5", "--opacity", "0.35,1", "--colour", "d8d0c0,c8553d", "--zoom", "1.35"],
  ],
];

const compared: [string, string, number][] = [
  ["fuel", "fuel.nhdr", 20.5],
  ["engine", "engine.nhdr", 60.5],
  ["aneurysm", "aneurysm.nhdr", 40.5],
];

export async function drawFigures(bench: Bench, wanted: RegExp): Promise<void> {
  for (const [name, file, options] of drawn) {
    const volume = wanted.test(name) && bench.volume(file);
    if (!volume) continue;
    const store = join(bench.folder, `${name}.isosplat`);
    await bench.command(bench.isosplat, ["build", volume, "-o", store]);
    const view = options.includes("-i")
      ? ["--size", "800x700"]
      : ["-i", "20.5", "--size", "480x400", "--zoom", "1.8", "--aliased"];
    const picture = ["-o", join(folder, `${name}.png`)];
    await bench.command(bench.isosplat, ["render", store, ...view, ...options, ...picture]);
  }
  for (const [name, file, isovalue] of compared) {
    const volume = wanted.test(`figure_7_${name}`) && bench.volume(file);
    const mesh = volume && (await flyingEdgesMesh(bench, volume, isovalue));
    if (!mesh) continue;
    const view = ["--size", "480", "--view", "front", "--kind"];
    for (const kind of ["mesh", "exact"]) {
      const options = ["--mesh", mesh, "--pictures", bench.folder, ...view, kind];
      const program = renderProgram("isosplat_fidelity");
      await bench.command(program, [volume, String(isovalue), ...options]);
      copyFileSync(
        join(bench.folder, `front-${kind}.png`),
        join(folder, `figure_7_${name}_${kind}.png`),
      );
    }
  }
}
