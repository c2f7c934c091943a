/**
 * Reads damaged volumes and builds their stores in WebAssembly. The result is a store or one error,
 * never an abort.
 */
import { gzipSync } from "node:zlib";
import { beforeAll, expect, test } from "vitest";
import { CoreError } from "../../web/core/index.ts";
import { Chance } from "../support/chance.ts";
import { dicomSlice } from "../support/dicom_files.ts";
import { buildFrom, type LocalPrograms, localPrograms } from "../support/local_build.ts";
import { fileOf } from "../support/local_import.ts";
import { tiffOf } from "../support/tiff_files.ts";

/** Edits of each file. `ISOSPLAT_FUZZ_EDITS=10000 npx vitest run tests/web/import_fuzz.spec.ts` */
const edits = Number(process.env.ISOSPLAT_FUZZ_EDITS ?? 100);
const seed = Number(process.env.ISOSPLAT_FUZZ_SEED ?? 1);
const memoryBytes = 128 << 20;
const [width, height, depth] = [9, 7, 6];
const voxels = Uint8Array.from({ length: width * height * depth }, (_, i) => (i * 37) % 251);

const text = (lines: readonly string[]) => Buffer.from(`${lines.join("\n")}\n`, "latin1");

function nrrd(encoding: string, data: Uint8Array): Buffer {
  const sizes = `sizes: ${width} ${height} ${depth}`;
  const spacings = "space directions: (0.5,0,0) (0,0.6,0.08) (0,0,1.25)";
  const header = ["NRRD0004", "type: uint8", "dimension: 3", "space: left-posterior-superior"];
  return Buffer.concat([text([...header, sizes, spacings, `encoding: ${encoding}`, ""]), data]);
}

function nifti(): Buffer {
  const header = Buffer.alloc(352);
  header.writeInt32LE(348, 0);
  [3, width, height, depth, 1, 1, 1, 1].forEach((n, i) => {
    header.writeInt16LE(n, 40 + 2 * i);
  });
  header.writeInt16LE(2, 70); // unsigned bytes
  header.writeInt16LE(8, 72);
  [1, 0.5, 0.6, 1.25].forEach((n, i) => {
    header.writeFloatLE(n, 76 + 4 * i);
  });
  header.writeFloatLE(352, 108);
  header.write("n+1\0", 344, "latin1");
  return Buffer.concat([header, voxels]);
}

function mrc(): Buffer {
  const header = Buffer.alloc(1024);
  [width, height, depth, 0, 0, 0, 0, width, height, depth].forEach((n, i) => {
    header.writeInt32LE(n, 4 * i);
  });
  [5, 6, 7, 90, 90, 90].forEach((n, i) => {
    header.writeFloatLE(n, 40 + 4 * i);
  });
  [1, 2, 3].forEach((n, i) => {
    header.writeInt32LE(n, 64 + 4 * i);
  });
  header.write("MAP DD\0\0", 208, "latin1");
  return Buffer.concat([header, voxels]);
}

function numpy(): Buffer {
  const fields = `{'descr': '|u1', 'fortran_order': False, 'shape': (${depth}, ${height}, ${width}), }`;
  const header = Buffer.from(`${fields.padEnd(117)}\n`, "latin1");
  const start = Buffer.from([0x93, 0x4e, 0x55, 0x4d, 0x50, 0x59, 1, 0, header.length, 0]);
  return Buffer.concat([start, header, voxels]);
}

const metaImage = [
  "ObjectType = Image",
  "NDims = 3",
  `DimSize = ${width} ${height} ${depth}`,
  "ElementSpacing = 0.5 0.6 1.25",
  "ElementType = MET_UCHAR",
  "ElementDataFile = LOCAL",
];
const vtk = [
  "# vtk DataFile Version 3.0",
  "a volume",
  "BINARY",
  "DATASET STRUCTURED_POINTS",
  `DIMENSIONS ${width} ${height} ${depth}`,
  "ORIGIN 0 0 0",
  "SPACING 0.5 0.6 1.25",
  `POINT_DATA ${voxels.length}`,
  "SCALARS values unsigned_char 1",
  "LOOKUP_TABLE default",
];
const vti = [
  '<VTKFile type="ImageData" version="0.1" byte_order="LittleEndian">',
  `<ImageData WholeExtent="0 ${width - 1} 0 ${height - 1} 0 ${depth - 1}" Spacing="0.5 0.6 1.25">`,
  `<Piece Extent="0 ${width - 1} 0 ${height - 1} 0 ${depth - 1}"><PointData>`,
  `<DataArray type="UInt8" Name="values" format="ascii">${voxels.join(" ")}</DataArray>`,
  "</PointData></Piece></ImageData></VTKFile>",
];
const tiff = { width, height, bits: 8, format: 1 } as const;
const files: [path: string, bytes: Uint8Array][] = [
  ["a.nrrd", nrrd("raw", voxels)],
  ["a.nrrd", nrrd("gzip", gzipSync(voxels))],
  ["a.nii", nifti()],
  ["a.nii.gz", gzipSync(nifti())],
  ["a.mrc", mrc()],
  ["a.npy", numpy()],
  ["a.mha", Buffer.concat([text(metaImage), voxels])],
  ["a.vtk", Buffer.concat([text(vtk), voxels])],
  ["a.vti", text(vti)],
  ["a.tif", tiffOf(tiff, voxels)],
  ["a.tif", tiffOf({ ...tiff, compression: 8 }, voxels)],
  ["a.dcm", dicomSlice(Uint16Array.from(voxels.subarray(0, 36)), 6, 0)],
];

let programs: LocalPrograms;

beforeAll(async () => {
  programs = await localPrograms();
});

/** Bytes that are changed, inserted, removed, or cut off; mostly near the beginning, where headers are. */
function damaged(bytes: Uint8Array, chance: Chance): Buffer {
  let result = Buffer.from(bytes);
  for (let n = chance.whole(1, 4); n > 0; --n) {
    const end = chance.next() < 0.7 ? Math.min(result.length, 400) : result.length;
    const at = chance.whole(0, Math.max(0, end - 1));
    const [before, rest] = [result.subarray(0, at), result.subarray(at)];
    switch (chance.whole(0, 4)) {
      case 0:
        if (at < result.length) result[at] = chance.of([0, 1, 0x2d, 0x39, 0x7f, 0x80, 0xff]);
        break;
      case 1:
        if (at < result.length) result[at] = (result[at] ?? 0) ^ (1 << chance.whole(0, 7));
        break;
      case 2:
        result = Buffer.concat([before, rest.subarray(chance.whole(1, 9))]);
        break;
      case 3:
        result = Buffer.concat([before, rest.subarray(0, chance.whole(1, 9)), rest]);
        break;
      default:
        if (chance.next() < 0.3) result = Buffer.from(before);
    }
  }
  return result;
}

/** Returns whether a store was built. Throws errors that are not meant for users. */
async function survives(path: string, bytes: Uint8Array): Promise<boolean> {
  try {
    await buildFrom(programs, [fileOf(path, bytes)], path, {}, { memoryBytes });
    return true;
  } catch (error) {
    if (!(error instanceof CoreError)) throw error;
    expect(error.message.length).toBeGreaterThan(20);
    return false;
  }
}

test.each(files)(
  "%s %#: damage leads to a store or to one error",
  async (path, bytes) => {
    if (!path.endsWith(".dcm")) expect(await survives(path, bytes)).toBe(true);
    const chance = new Chance(seed);
    let refused = 0;
    for (let i = 0; i < edits; ++i) {
      const bad = damaged(bytes, chance);
      try {
        refused += Number(!(await survives(path, bad)));
      } catch (error) {
        throw new Error(`edit ${i} of seed ${seed}: ${bad.toString("base64")}`, { cause: error });
      }
    }
    expect(refused).toBeGreaterThan(0);
  },
  120_000,
);
