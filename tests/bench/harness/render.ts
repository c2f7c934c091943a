import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import type { Bench } from "./benchmark.ts";
import { readNrrd } from "./flying_edges.ts";
import { root } from "./paths.ts";

/** A program of tests/bench/render. */
export const renderProgram = (name: string) =>
  join(root, `build/release/tests/bench/render/${name}`);

/** The distances of voxels in an NRRD file. */
export function spacingOf(volume: string): string[] {
  const header = readFileSync(volume).subarray(0, 4096).toString("latin1");
  return header.match(/^spacings:[ \t]*(.*?)\r?$/m)?.[1]?.split(/\s+/) ?? ["1", "1", "1"];
}

/**
 * Writes VTK's Flying Edges mesh of an isovalue. Returns the file, or undefined if VTK is missing.
 */
export async function flyingEdgesMesh(
  bench: Bench,
  volume: string,
  isovalue: number,
): Promise<string | undefined> {
  const python = bench.pythonWithVtk();
  if (!python) return undefined;
  const { voxels, type, data } = readNrrd(volume);
  const raw = join(bench.folder, "mesh.raw");
  const mesh = join(bench.folder, `mesh-${isovalue}.bin`);
  writeFileSync(raw, data);
  const script = join(root, "tests/evidence/peers/flying_edges_mesh.py");
  const numbers = [...voxels.map(String), type, ...spacingOf(volume), String(isovalue)];
  await bench.command(python, [script, raw, ...numbers, mesh]);
  return mesh;
}
