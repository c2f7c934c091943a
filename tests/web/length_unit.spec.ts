// Lengths of volumes whose files state no distance between voxels are in voxels.
import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { afterAll, expect, test } from "vitest";
import { loadCore } from "../../web/core/index.ts";
import type { Triple } from "../../web/core/types.ts";
import { reducedVolume } from "../../web/import/reduced_volume.ts";
import { unitOf } from "../../web/overlay/length_unit.ts";
import { formatLength, formatMeasured, formatPower } from "../../web/overlay/lengths.ts";
import { tiffOf } from "../support/tiff_files.ts";

const isosplat = fileURLToPath(new URL("../../build/release/native/cli/isosplat", import.meta.url));
const folder = mkdtempSync(join(tmpdir(), "isosplat-unit-"));
afterAll(() => rmSync(folder, { recursive: true, force: true }));

const voxels = Uint8Array.from({ length: 512 }, (_, i) => (i * 37) % 251);
const nrrd = (more: string) =>
  `NRRD0004\ntype: uint8\ndimension: 3\nsizes: 8 8 8\nencoding: raw\n${more}\n`;
const mha = (more: string) =>
  `ObjectType = Image\nNDims = 3\nDimSize = 8 8 8\n${more}ElementType = MET_UCHAR\nElementDataFile = LOCAL\n`;
const vtk = (more: string) =>
  `# vtk DataFile Version 3.0\nv\nBINARY\nDATASET STRUCTURED_POINTS\nDIMENSIONS 8 8 8\nORIGIN 0 0 0\n${more}POINT_DATA 512\nSCALARS s unsigned_char 1\nLOOKUP_TABLE default\n`;
const npyHeader = "{'descr': '|u1', 'fortran_order': False, 'shape': (8, 8, 8), }".padEnd(117);

function withVoxels(header: string): Buffer {
  return Buffer.concat([Buffer.from(header, "latin1"), voxels]);
}

/** An MRC file (CCP-EM, MRC2014) of 8³ bytes whose cell has this edge, in ångström. */
function mrc(edge: number): Buffer {
  const header = Buffer.alloc(1024);
  for (const [i, word] of [8, 8, 8, 0, 0, 0, 0, 8, 8, 8].entries())
    header.writeInt32LE(word, 4 * i);
  for (let i = 10; i < 13; ++i) header.writeFloatLE(edge, 4 * i);
  for (let i = 13; i < 16; ++i) header.writeFloatLE(90, 4 * i);
  for (const [i, word] of [1, 2, 3].entries()) header.writeInt32LE(word, 4 * (16 + i));
  header.write("MAP ", 208, "latin1");
  header.set([0x44, 0x44, 0, 0], 212);
  return Buffer.concat([header, voxels]);
}

const tiff = tiffOf(
  { width: 8, height: 8, bits: 8, format: 1, compression: 8 },
  Buffer.from(voxels),
);

const known: [what: string, file: string, content: Uint8Array, flags: string[]][] = [
  ["NRRD with spacings of 1", "a.nrrd", withVoxels(nrrd("spacings: 1 1 1\n")), []],
  ["MetaImage with spacings of 1", "a.mha", withVoxels(mha("ElementSpacing = 1 1 1\n")), []],
  ["VTK with spacings of 1", "a.vtk", withVoxels(vtk("SPACING 1 1 1\n")), []],
  ["MRC with a cell of 8 Å", "a.mrc", mrc(8), []],
  ["NumPy with --spacing", "a.npy", withVoxels(`\x93NUMPY\x01\x00v\x00${npyHeader}\n`), ["1,1,1"]],
];
const unknown: typeof known = [
  ["raw", "b_8x8x8_uint8.raw", voxels, []],
  ["NumPy", "b.npy", withVoxels(`\x93NUMPY\x01\x00v\x00${npyHeader}\n`), []],
  ["NRRD", "b.nrrd", withVoxels(nrrd("")), []],
  ["MetaImage", "b.mha", withVoxels(mha("")), []],
  ["VTK", "b.vtk", withVoxels(vtk("")), []],
  ["MRC without a cell", "b.mrc", mrc(0), []],
  ["TIFF", "b.tif", tiff, []],
];

/** Builds the store of a file with the program. */
async function unitOfFile(file: string, content: Uint8Array, [spacing]: string[]) {
  const path = join(folder, file);
  const store = `${path}.isosplat`;
  writeFileSync(path, content);
  const flags = spacing === undefined ? [] : ["--spacing", spacing];
  execFileSync(isosplat, ["build", path, "-q", "-o", store, "--no-thumbnail", ...flags]);
  const core = await loadCore();
  const opened = core.openStore(readFileSync(store));
  const unit = unitOf(opened.info);
  opened.close();
  return unit;
}

for (const [what, ...file] of unknown) {
  test(`${what}: voxels`, async () => expect(await unitOfFile(...file)).toBe("voxel"));
}
for (const [what, ...file] of known) {
  test(`${what}: millimetres`, async () => expect(await unitOfFile(...file)).toBe("mm"));
}

test("a reduced copy: voxels of its file", () => {
  const { description } = reducedVolume(
    {
      name: "raw",
      format: "raw",
      type: "u8",
      voxels: [129, 2, 2],
      notes: ["a raw file has no voxel spacing: 1,1,1 is assumed; --spacing sets another"],
    },
    () => new Uint8Array(2 * 129),
  );
  const [x, y, z] = description.spacing ?? [];
  const spacing: Triple = [x ?? 0, y ?? 0, z ?? 0];
  expect(spacing).toEqual([2, 1, 1]);
  expect(unitOf({ metadata: { notes: [...(description.notes ?? [])] }, spacing })).toBe("voxel");
});

test("lengths in voxels have no unit of the world", () => {
  expect(formatLength(25, "voxel")).toBe("25 voxels");
  expect(formatLength(1, "voxel")).toBe("1 voxel");
  expect(formatLength(0, "voxel")).toBe("0 voxels");
  expect(formatMeasured(56.4942, 1, "voxel")).toBe("56.5 voxels");
  expect(formatPower(12.5, 2, "voxel")).toBe("12.5 voxels²");
  expect(formatPower(1000, 3, "voxel")).toBe("1000 voxels³");
});
