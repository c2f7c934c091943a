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

/** The labels of the field "region": in slabs along z, below 30, from 30 to 39, and above. */
export const regions = [
  { value: 3, name: "lower", colour: "#d01010" },
  { value: 7, name: "middle", colour: "#10c010" },
  { value: 200, name: "upper", colour: "#1010d0" },
] as const;
export const regionAt = (z: number): (typeof regions)[number] =>
  z < 30 ? regions[0] : z < 40 ? regions[1] : regions[2];

/** A volume with the values of a function at each voxel, as bytes. */
function filled(
  Values: typeof Uint8Array,
  of: (x: number, y: number, z: number) => number,
): Uint8Array;
function filled(
  Values: typeof Float32Array,
  of: (x: number, y: number, z: number) => number,
): Float32Array;
function filled(
  Values: typeof Uint8Array | typeof Float32Array,
  of: (x: number, y: number, z: number) => number,
): Uint8Array | Float32Array {
  const [nx, ny, nz] = voxels;
  const values = new Values(nx * ny * nz);
  let at = 0;
  for (let z = 0; z < nz; ++z) {
    for (let y = 0; y < ny; ++y) {
      for (let x = 0; x < nx; ++x, ++at) values[at] = of(x, y, z);
    }
  }
  return values;
}

/** Writes a volume as NRRD, and returns its path. */
function writeNrrd(folder: string, name: string, values: Uint8Array | Float32Array): string {
  const type = values instanceof Uint8Array ? "uint8" : "float";
  const header =
    `NRRD0004\ntype: ${type}\ndimension: 3\nsizes: ${voxels.join(" ")}\nspacings: 1 1 1\n` +
    "encoding: raw\nendian: little\n\n";
  const bytes = new Uint8Array(values.buffer);
  writeFileSync(join(folder, name), Buffer.concat([Buffer.from(header), bytes]));
  return join(folder, name);
}

function build(folder: string, name: string, field: string): string {
  const store = join(folder, `${name}.isosplat`);
  const volume = writeNrrd(folder, `${name}.nrrd`, filled(Uint8Array, ball));
  execFileSync(program, ["build", volume, "--field", field, "-o", store], { stdio: "pipe" });
  return store;
}

/** Writes ball.isosplat with the field "pressure" into a folder, and returns its path. */
export function writeFieldStore(folder: string): string {
  const values = filled(Float32Array, (x, y, z) =>
    hasPressure(x, y) ? pressure(x, y, z) : Number.NaN,
  );
  return build(folder, "ball", `pressure=${writeNrrd(folder, "pressure.nrrd", values)}`);
}

/** Writes parcels.isosplat, the same ball with the field "region", whose values are labels, and returns its path. */
export function writeLabelledStore(folder: string): string {
  const labels = writeNrrd(
    folder,
    "region.nrrd",
    filled(Uint8Array, (_x, _y, z) => regionAt(z).value),
  );
  const table = join(folder, "region.csv");
  const rows = regions.map(({ value, name, colour }) => {
    const channels = [1, 3, 5].map((at) => Number.parseInt(colour.slice(at, at + 2), 16));
    return [value, name, ...channels].join(",");
  });
  writeFileSync(table, ["value,name,r,g,b", ...rows, ""].join("\n"));
  return build(folder, "parcels", `region=@labels(${labels},${table})`);
}
