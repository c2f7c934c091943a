/** A store with a field, whose values are known. */
import { execFileSync } from "node:child_process";
import { writeFileSync } from "node:fs";
import { join } from "node:path";
import { program } from "../browser/support/server.ts";

/** More than one block along x and y. */
const voxels = [150, 131, 70] as const;

/** The isosurface of v is a ball of radius v / 3 around (75, 65, 35), cut by the volume above 105. */
const ball = (x: number, y: number, z: number): number =>
  Math.min(255, Math.round(3 * Math.hypot(x - 75, y - 65, z - 35)));

/** The field. It has no value where hasPressure() is false. */
export const pressure = (x: number, y: number, z: number): number => 4 * x + 8 * y + 16 * z;
export const hasPressure = (x: number, y: number): boolean => x + y > 120;

/** Writes ball.isosplat with the field "pressure" into a folder, and returns its path. */
export function writeFieldStore(folder: string): string {
  const [nx, ny, nz] = voxels;
  const first = new Uint8Array(nx * ny * nz);
  const second = new Float32Array(nx * ny * nz);
  let at = 0;
  for (let z = 0; z < nz; ++z) {
    for (let y = 0; y < ny; ++y) {
      for (let x = 0; x < nx; ++x, ++at) {
        first[at] = ball(x, y, z);
        second[at] = hasPressure(x, y) ? pressure(x, y, z) : Number.NaN;
      }
    }
  }
  const write = (name: string, type: string, values: Uint8Array | Float32Array): string => {
    const header =
      `NRRD0004\ntype: ${type}\ndimension: 3\nsizes: ${voxels.join(" ")}\nspacings: 1 1 1\n` +
      "encoding: raw\nendian: little\n\n";
    const bytes = new Uint8Array(values.buffer);
    writeFileSync(join(folder, name), Buffer.concat([Buffer.from(header), bytes]));
    return join(folder, name);
  };
  const store = join(folder, "ball.isosplat");
  const field = `pressure=${write("pressure.nrrd", "float", second)}`;
  const volume = write("ball.nrrd", "uint8", first);
  execFileSync(program, ["build", volume, "--field", field, "-o", store], { stdio: "pipe" });
  return store;
}
