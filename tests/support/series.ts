/** Volumes that change with time, written for tests and benchmarks. */
import { execFileSync } from "node:child_process";
import { mkdirSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { program } from "../browser/support/server.ts";

/** A ball whose centre and radius are fractions of the volume's edge. */
export interface Ball {
  centre: readonly [number, number, number];
  radius: number;
}

/** The isovalue of a ball's surface. */
export const ballIsovalue = 100;

/** Voxels of 8 bits: 100 on the ball's surface, and more inside. */
export function ballVoxels(edge: number, { centre, radius }: Ball): Uint8Array {
  const voxels = new Uint8Array(edge ** 3);
  const [cx, cy, cz] = centre.map((each) => each * (edge - 1)) as [number, number, number];
  // The values fall over the whole volume, so that only cells at the surface are active.
  const fall = 100 / (radius * edge);
  for (let z = 0, at = 0; z < edge; ++z) {
    for (let y = 0; y < edge; ++y) {
      const across = (y - cy) ** 2 + (z - cz) ** 2;
      for (let x = 0; x < edge; ++x, ++at) {
        const distance = Math.sqrt((x - cx) ** 2 + across);
        voxels[at] = Math.max(0, Math.min(255, Math.round(200 - fall * distance)));
      }
    }
  }
  return voxels;
}

/** Writes the volume as NRRD, and builds its store NAME.isosplat in the folder. */
export function buildBall(folder: string, name: string, edge: number, ball: Ball): void {
  mkdirSync(folder, { recursive: true });
  const header = `NRRD0004\ntype: uint8\ndimension: 3\nsizes: ${edge} ${edge} ${edge}\nencoding: raw\n\n`;
  const file = join(folder, `${name}.nrrd`);
  writeFileSync(file, Buffer.concat([Buffer.from(header), ballVoxels(edge, ball)]));
  const store = join(folder, `${name}.isosplat`);
  execFileSync(program, ["build", file, "-o", store, "--quiet", "--no-thumbnail"]);
}
