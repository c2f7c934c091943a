/**
 * Compares the importer in WebAssembly with the program: volumes, notes, errors and stores must be
 * the same.
 */
import { spawnSync } from "node:child_process";
import {
  copyFileSync,
  cpSync,
  existsSync,
  mkdirSync,
  mkdtempSync,
  readdirSync,
  readFileSync,
  rmSync,
  writeFileSync,
} from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { brotliCompressSync, deflateSync, gzipSync } from "node:zlib";
import { afterAll, beforeAll, describe, expect, test } from "vitest";
import { CoreError } from "../../web/core/index.ts";
import { ChoiceError, type ImportOptions, volumesAmong } from "../../web/import/index.ts";
import { dicomSegmentation, dicomSlice } from "../support/dicom_files.ts";
import {
  buildFrom,
  buildLocally,
  type LocalPrograms,
  localPrograms,
} from "../support/local_build.ts";
import { fileOf, filesOf, localImporter, sparseFile } from "../support/local_import.ts";
import { type TiffForm, tiffOf } from "../support/tiff_files.ts";

const root = fileURLToPath(new URL("../..", import.meta.url));
const isosplat = join(root, "build/release/native/cli/isosplat");
const volumes = process.env.ISOSPLAT_VOLUMES ?? join(root, "../shared/volumes");
const cases = join(root, "../shared/cases/import");
const folder = mkdtempSync(join(tmpdir(), "isosplat-import-"));

let programs: LocalPrograms;

beforeAll(async () => {
  programs = await localPrograms();
});

afterAll(() => rmSync(folder, { recursive: true, force: true }));

/**
 * Builds the store of a volume with the program, which writes it into the same folder. Returns the
 * store, or the error.
 */
function buildNatively(inside: string, path: string, flags: string[]): Uint8Array | string {
  const { status, stderr } = spawnSync(isosplat, ["build", path, "-q", ...flags], { cwd: inside });
  if (status !== 0) return stderr.toString();
  const [store] = readdirSync(inside).filter((name) => name.endsWith(".isosplat"));
  const bytes = readFileSync(join(inside, store as string));
  for (const name of readdirSync(inside)) {
    if (/\.isosplat/.test(name)) rmSync(join(inside, name));
  }
  return bytes;
}

/** Builds the store as the browser does, or returns the error's message. */
async function buildHere(
  inside: string,
  path: string,
  options: ImportOptions,
): Promise<Uint8Array | string> {
  try {
    return await buildFrom(programs, filesOf(inside), path, options);
  } catch (error) {
    if (error instanceof CoreError) return error.message.slice(error.status.length + 2);
    throw error;
  }
}

async function compare(
  inside: string,
  path: string,
  flags: string[] = [],
  options: ImportOptions = {},
): Promise<void> {
  const native = buildNatively(inside, path, flags);
  const here = await buildHere(inside, path, options);
  if (typeof native === "string") {
    expect(native).toContain(here);
  } else {
    expect(typeof here === "string" ? here : "a store").toBe("a store");
    expect(Buffer.compare(here as Uint8Array, native)).toBe(0);
  }
}

let folders = 0;
function newFolder(files: Record<string, string | Uint8Array>): string {
  const inside = join(folder, `${folders++}`);
  for (const [name, content] of Object.entries(files)) {
    mkdirSync(join(inside, name, ".."), { recursive: true });
    writeFileSync(join(inside, name), content);
  }
  return inside;
}

const arrays = {
  uint8: Uint8Array,
  int8: Int8Array,
  uint16: Uint16Array,
  int16: Int16Array,
  uint32: Uint32Array,
  int32: Int32Array,
  uint64: BigUint64Array,
  int64: BigInt64Array,
  float: Float32Array,
  double: Float64Array,
};
type ArrayName = keyof typeof arrays;

/** Voxels of every type with values between 0 and 120, rising from corner to corner. */
function voxelsOf(type: ArrayName, [x, y, z]: readonly number[]): Uint8Array {
  const count = (x as number) * (y as number) * (z as number);
  const value = (i: number): number => Math.floor((i * 120) / count) + (i % 3);
  if (type === "uint64" || type === "int64") {
    const voxels = new arrays[type](count).map((_, i) => BigInt(value(i)) << 20n);
    return new Uint8Array(voxels.buffer);
  }
  const voxels = new arrays[type](count);
  for (let i = 0; i < count; ++i) voxels[i] = value(i);
  return new Uint8Array(voxels.buffer);
}

const nrrd = (type: string, sizes: readonly number[], more: string): string =>
  `NRRD0004\ntype: ${type}\ndimension: 3\nsizes: ${sizes.join(" ")}\n${more}\n`;

describe("a store equals that of the program, byte by byte", () => {
  const sizes = [37, 5, 70];
  test.each(Object.keys(arrays) as ArrayName[])("NRRD of %s", async (type) => {
    const header = nrrd(
      type,
      sizes,
      "space: RAS\nspace directions: (0.5,0,0) (0,-0.6,0.1) (0,0,2)\nspace origin: (0,0,0)\nendian: little\nencoding: raw\n",
    );
    const content = Buffer.concat([Buffer.from(header), voxelsOf(type, sizes)]);
    await compare(newFolder({ "a.nrrd": content }), "a.nrrd");
  });

  test.each(["gzip", "raw", "ascii", "hex"])(
    "NRRD with data in another file, %s",
    async (coding) => {
      const voxels = voxelsOf("uint8", sizes);
      const data = {
        gzip: gzipSync(voxels),
        raw: voxels,
        ascii: voxels.join(" "),
        hex: Buffer.from(voxels).toString("hex"),
      }[coding] as string;
      const header = nrrd(
        "uint8",
        sizes,
        `spacings: 1 1.5 2\nencoding: ${coding}\ndata file: sub/a.data\n`,
      );
      await compare(newFolder({ "a.nhdr": header, "sub/a.data": data }), "a.nhdr");
    },
  );

  test.each([false, true])("MetaImage, compressed: %s", async (compressed) => {
    const voxels = voxelsOf("int16", sizes);
    const header = `ObjectType = Image\nNDims = 3\nDimSize = ${sizes.join(" ")}\nElementType = MET_SHORT\nElementSpacing = 1 2 3\nOffset = -4 5 6.5\nElementByteOrderMSB = False\nCompressedData = ${compressed ? "True" : "False"}\nElementDataFile = a.zraw\n`;
    const data = compressed ? deflateSync(voxels) : voxels;
    await compare(newFolder({ "a.mhd": header, "a.zraw": data }), "a.mhd");
  });

  /** An MRC file with a cell of 2 ångström a voxel; `mode` is that of MRC2014. */
  const mrc = (mode: number, voxels: Uint8Array, more: [word: number, value: number][] = []) => {
    const header = Buffer.alloc(1024);
    [...sizes, mode].forEach((value, i) => {
      header.writeInt32LE(value, 4 * i);
    });
    for (const [i, size] of sizes.entries()) {
      header.writeInt32LE(size, 4 * (7 + i));
      header.writeFloatLE(2 * size, 4 * (10 + i));
      header.writeFloatLE(90, 4 * (13 + i));
      header.writeInt32LE(i + 1, 4 * (16 + i));
    }
    header.write("MAP DD", 208);
    for (const [word, value] of more) header.writeInt32LE(value, 4 * (word - 1));
    return Buffer.concat([header, voxels]);
  };
  test.each<[number, ArrayName]>([
    [0, "int8"],
    [1, "int16"],
    [2, "float"],
    [6, "uint16"],
    [12, "uint16"],
  ])("MRC of mode %i", async (mode, type) => {
    const file = mrc(mode, voxelsOf(type, sizes));
    const inside = newFolder({ "a.mrc": file, "b.map.gz": gzipSync(file) });
    await compare(inside, "a.mrc");
    await compare(inside, "b.map.gz");
  });

  /** A volume of FreeSurfer, of 16-bit integers. */
  const mgh = (voxels: Uint8Array): Buffer => {
    const header = Buffer.alloc(284);
    [1, ...sizes, 1, 4].forEach((value, i) => {
      header.writeInt32BE(value, 4 * i);
    });
    header.writeInt16BE(1, 28);
    [1, 2, 3, -1, 0, 0, 0, 0, -1, 0, 1, 0, 5, 6, 7].forEach((value, i) => {
      header.writeFloatBE(value, 30 + 4 * i);
    });
    return Buffer.concat([header, Buffer.from(voxels).swap16()]);
  };
  test("FreeSurfer's MGH and MGZ", async () => {
    const file = mgh(voxelsOf("int16", sizes));
    const inside = newFolder({
      "a.mgh": file,
      "b.mgz": gzipSync(file),
      unnamed: file,
      "cut.mgh": file.subarray(0, 5000),
    });
    for (const name of ["a.mgh", "b.mgz", "unnamed", "cut.mgh"]) await compare(inside, name);
  });

  test("faults of MRC have the program's words", async () => {
    const voxels = voxelsOf("uint8", sizes);
    const inside = newFolder({
      "cut.mrc": mrc(0, voxels.subarray(3)),
      "axes.mrc": mrc(0, voxels, [[17, 2]]),
      "complex.mrc": mrc(4, voxels),
    });
    for (const name of ["cut.mrc", "axes.mrc", "complex.mrc"]) await compare(inside, name);
  });

  /** A NumPy file in C order: its axes are z, y, x. */
  const npy = (type: string, voxels: Uint8Array, order = "False"): Buffer => {
    const shape = `(${[...sizes].reverse().join(", ")})`;
    const text = `{'descr': '${type}', 'fortran_order': ${order}, 'shape': ${shape}, }`;
    const head = Buffer.from(`\x93NUMPY\x01\0\0\0${text.padEnd(117)}\n`, "latin1");
    head.writeUInt16LE(118, 8);
    return Buffer.concat([head, voxels]);
  };
  test.each<[string, ArrayName]>([
    ["|i1", "int8"],
    ["<i8", "int64"],
    [">f4", "float"],
    ["<f2", "uint16"],
  ])("NumPy's %s, in both orders", async (name, type) => {
    const voxels = voxelsOf(type, sizes);
    const files = { "c.npy": npy(name, voxels), "fortran.npy": npy(name, voxels, "True") };
    const inside = newFolder(files);
    for (const path of Object.keys(files)) await compare(inside, path);
  });

  test("faults of NumPy's files have the program's words", async () => {
    const voxels = voxelsOf("uint8", sizes);
    const inside = newFolder({
      "cut.npy": npy("|u1", voxels.subarray(3)),
      "type.npy": npy("|O", voxels),
      "order.npy": npy("|u1", voxels, "None"),
    });
    for (const name of ["cut.npy", "type.npy", "order.npy"]) await compare(inside, name);
  });

  // Files written by the HDF5 library. If they are refused, the message is the program's.
  const hdf5 = join(root, "tests/native/hdf5");
  const hdf5Files = readdirSync(hdf5).filter((name) => name.endsWith(".h5"));
  test.each(hdf5Files)("HDF5: %s", async (name) => {
    const inside = newFolder({ [name]: readFileSync(join(hdf5, name)) });
    await compare(inside, name);
  });

  // Files of the conventions of programs; BigDataViewer's has an XML file beside it.
  const conventions = join(hdf5, "conventions");
  const chosen: Record<string, [string[], object]> = {
    "imaris.ims": [["--channel", "1", "--time-step", "1"], { channel: 1, timeStep: 1 }],
    "bdv.h5": [["--channel", "1", "--time-step", "1"], { channel: 1, timeStep: 1 }],
    "time.nc": [["--time-step", "1"], { timeStep: 1 }],
  };
  const conventionFiles = readdirSync(conventions).filter((name) => !name.endsWith(".xml"));
  test.each(conventionFiles)("HDF5 by convention: %s", async (name) => {
    const files: Record<string, Buffer> = { [name]: readFileSync(join(conventions, name)) };
    if (name === "bdv.h5") files["bdv.xml"] = readFileSync(join(conventions, "bdv.xml"));
    const [flags, options] = chosen[name] ?? [[], {}];
    await compare(newFolder(files), name, flags, options);
  });

  test("a dataset of an HDF5 file with several, and their list", async () => {
    const name = "several.h5";
    const inside = newFolder({ [name]: readFileSync(join(hdf5, name)) });
    for (const dataset of ["/a/b/long", "/image"]) {
      await compare(inside, name, ["--dataset", dataset], { dataset });
    }
    const inputs = filesOf(inside);
    const reader = await localImporter(programs.importer, inputs);
    const found = volumesAmong(
      inputs,
      (path) => reader.detect(path),
      (path) => reader.choices(path),
    );
    expect(found.map(({ format, choice }) => [format, choice?.options.dataset])).toEqual([
      ["HDF5", "/a/b/half"],
      ["HDF5", "/a/b/long"],
      ["HDF5", "/again"],
    ]);
  });

  test.each(["ASCII", "BINARY"])("legacy VTK, %s", async (kind) => {
    const voxels = voxelsOf("uint8", sizes);
    const header = `# vtk DataFile Version 3.0\nscan\n${kind}\nDATASET STRUCTURED_POINTS\nDIMENSIONS ${sizes.join(" ")}\nSPACING 1 1 2\nORIGIN 0 0 0\nPOINT_DATA ${voxels.length}\nSCALARS density unsigned_char\nLOOKUP_TABLE default\n`;
    const data = kind === "ASCII" ? Buffer.from(voxels.join("\n")) : Buffer.from(voxels);
    await compare(newFolder({ "a.vtk": Buffer.concat([Buffer.from(header), data]) }), "a.vtk");
  });

  /** A VTK XML image; `coding` is that of its values. */
  const vti = (coding: string, voxels: Uint8Array): Buffer => {
    const [x, y, z] = sizes as [number, number, number];
    const extent = `0 ${x - 1} 0 ${y - 1} 0 ${z - 1}`;
    const words = (...numbers: number[]) => Buffer.from(new Uint32Array(numbers).buffer);
    const block = 4096;
    const blocks = Array.from({ length: Math.ceil(voxels.length / block) }, (_, i) =>
      deflateSync(voxels.subarray(i * block, (i + 1) * block)),
    );
    const compressed = [
      words(blocks.length, block, voxels.length % block, ...blocks.map((each) => each.length)),
      Buffer.concat(blocks),
    ];
    const plain = Buffer.concat([words(voxels.length), voxels]);
    const data = {
      ascii: voxels.join(" "),
      binary: plain.toString("base64"),
      appended: plain,
      zlib: Buffer.concat(compressed),
      "zlib in base64": compressed.map((part) => part.toString("base64")).join(""),
      lzma: plain,
    }[coding] as string | Buffer;
    const compressor = /zlib|lzma/.exec(coding)?.[0];
    const name = compressor === "lzma" ? "vtkLZMADataCompressor" : "vtkZLibDataCompressor";
    const isInside = typeof data === "string";
    const format = coding === "ascii" ? "ascii" : isInside ? "binary" : 'appended" offset="0';
    return Buffer.concat([
      Buffer.from(
        `<?xml version="1.0"?>\n<VTKFile type="ImageData" version="0.1" byte_order="LittleEndian"${compressor ? ` compressor="${name}"` : ""}>\n<ImageData WholeExtent="${extent}" Origin="1 2 3" Spacing="1 0.5 2">\n<Piece Extent="${extent}"><PointData><DataArray type="UInt8" Name="a" format="${format}">${isInside ? data : ""}</DataArray></PointData></Piece></ImageData>\n`,
      ),
      isInside ? Buffer.alloc(0) : Buffer.from('<AppendedData encoding="raw">_'),
      isInside ? Buffer.alloc(0) : data,
      Buffer.from(`${isInside ? "" : "</AppendedData>"}</VTKFile>`),
    ]);
  };
  test.each(["ascii", "binary", "appended", "zlib", "zlib in base64"])(
    "VTK XML, %s",
    async (coding) => {
      const file = vti(coding, voxelsOf("uint8", sizes));
      const inside = newFolder({ "a.vti": file, "cut.vti": file.subarray(0, file.length - 4500) });
      await compare(inside, "a.vti");
      await compare(inside, "cut.vti");
    },
  );

  test("VTK XML with LZMA is refused with the program's name", async () => {
    const inside = newFolder({ "a.vti": vti("lzma", voxelsOf("uint8", sizes)) });
    expect(await buildHere(inside, "a.vti", {})).toContain("program (isosplat build)");
  });

  test("a .pvti file and its pieces are one volume", async () => {
    const piece = (low: number, high: number, name: string) =>
      `<VTKFile type="ImageData"><ImageData WholeExtent="0 4 0 2 0 2" Spacing="1 1 1"><Piece Extent="${low} ${high} 0 2 0 2"${name}><PointData><DataArray type="UInt8" Name="a" format="ascii">${Array.from({ length: (high - low + 1) * 9 }, (_, i) => low + (i % (high - low + 1))).join(" ")}</DataArray></PointData></Piece></ImageData></VTKFile>`;
    const whole = `<VTKFile type="PImageData"><PImageData WholeExtent="0 4 0 2 0 2" Spacing="1 1 1"><Piece Extent="0 2 0 2 0 2" Source="a_0.vti"/><Piece Extent="2 4 0 2 0 2" Source="a_1.vti"/></PImageData></VTKFile>`;
    const inside = newFolder({
      "a.pvti": whole,
      "a_0.vti": piece(0, 2, ""),
      "a_1.vti": piece(2, 4, ""),
    });
    await compare(inside, "a.pvti");
    const inputs = filesOf(inside);
    const reader = await localImporter(programs.importer, inputs);
    const found = volumesAmong(
      inputs,
      (path) => reader.detect(path),
      (path) => reader.choices(path),
    );
    expect(found.map(({ path, files }) => [path, files])).toEqual([["a.pvti", 3]]);
  });

  test("formats of chemistry", async () => {
    const [x, y, z] = sizes as [number, number, number];
    const values = [...voxelsOf("uint8", sizes)].map((value) => value / 8).join(" ");
    const cell = "1 0 0\n0.2 1 0\n0 0 2\n";
    const steps = (sign: number) => `${sign * z} 0 0 2\n${sign * y} 0.2 1 0\n${sign * x} 1 0 0\n`;
    const grid = `${x} ${y} ${z}\n`;
    const inside = newFolder({
      "a.cube": `a\nb\n1 1 2 3\n${steps(1)}6 0 0 0 0\n${values}\n`,
      "b.cube": `a\nb\n-1 1 2 3\n${steps(-1)}6 0 0 0 0\n1 7\n${values}\n`,
      "cut.cube": `a\nb\n0 1 2 3\n${steps(1)}${values.slice(0, 9000)}\n`,
      CHGCAR: `a\n1.0\n${cell}Si\n1\nDirect\n0 0 0\n\n${grid}${values}\n${grid}${values}\n`,
      LOCPOT: `a\n-8\n${cell}Si\n1\nDirect\n0 0 0\n\n${grid}${values}\n`,
      POSCAR: `a\n1.0\n${cell}Si\n1\nDirect\n0 0 0\n`,
      "a.xsf": `CRYSTAL\nBEGIN_BLOCK_DATAGRID_3D\nd\nBEGIN_DATAGRID_3D_d\n${grid}0 0 0\n${cell}${values}\nEND_DATAGRID_3D\nEND_BLOCK_DATAGRID_3D\n`,
      "a.dx": `object 1 class gridpositions counts ${x} ${y} ${z}\norigin 0 0 0\ndelta 1 0 0\ndelta 0 1 0\ndelta 0 0 1\nobject 3 class array type double rank 0 items ${x * y * z} data follows\n${values}\n`,
    });
    for (const name of readdirSync(inside)) await compare(inside, name);
  });

  test("an archive of NumPy arrays", async () => {
    const content = npy("|u1", voxelsOf("uint8", sizes));
    const packed = deflateSync(content).subarray(2, -4);
    const name = "a.npy";
    const fields = Buffer.alloc(26);
    [20, 0, 8, 0, 33].forEach((value, i) => {
      fields.writeUInt16LE(value, 2 * i);
    });
    fields.writeUInt32LE(packed.length, 14);
    fields.writeUInt32LE(content.length, 18);
    fields.writeUInt16LE(name.length, 22);
    const local = Buffer.concat([Buffer.from("PK\x03\x04"), fields, Buffer.from(name), packed]);
    const entry = Buffer.concat([
      Buffer.from("PK\x01\x02\x14\0"),
      fields,
      Buffer.alloc(14),
      Buffer.from(name),
    ]);
    const end = Buffer.from("PK\x05\x06\0\0\0\0\x01\0\x01\0\0\0\0\0\0\0\0\0\0\0");
    end.writeUInt32LE(entry.length, 12);
    end.writeUInt32LE(local.length, 16);
    const file = Buffer.concat([local, entry, end]);
    const inside = newFolder({ "a.npz": file, "cut.npz": file.subarray(0, file.length - 1) });
    await compare(inside, "a.npz");
    await compare(inside, "cut.npz");
  });

  test("raw, with options and by its name", async () => {
    const voxels = voxelsOf("uint16", sizes);
    const inside = newFolder({ "a.raw": voxels, "b_37x5x70_uint16.raw.gz": gzipSync(voxels) });
    await compare(inside, "a.raw", ["--dims", "37x5x70", "--type", "u16", "--endian", "big"], {
      dims: [37, 5, 70],
      type: "u16",
      bigEndian: true,
    });
    await compare(inside, "b_37x5x70_uint16.raw.gz");
  });

  const imageJ =
    "ImageJ=1.53t\nimages=70\nslices=70\nunit=micron\nspacing=2.5\nloop=false\ncf=0\nc0=-7\nc1=0.5\n";
  const ome =
    '<?xml version="1.0"?><OME><Image><Pixels DimensionOrder="XYZCT" SizeX="37" SizeY="5" SizeZ="70" SizeC="1" SizeT="1" PhysicalSizeX="0.5" PhysicalSizeY="0.25" PhysicalSizeZ="2"/></Image></OME>';
  const [width, height] = sizes as [number, number];
  const tiffs: [string, ArrayName, Omit<TiffForm, "width" | "height">][] = [
    ["ImageJ's", "uint16", { bits: 16, format: 1, description: imageJ, pixelsPerUnit: 4.3 }],
    ["OME's, deflated", "int16", { bits: 16, format: 2, description: ome, compression: 8 }],
    ["big-endian", "float", { bits: 32, format: 3, bigEndian: true, rowsPerStrip: 2 }],
    ["PackBits", "uint8", { bits: 8, format: 1, compression: 32773, rowsPerStrip: 3 }],
  ];
  test.each(tiffs)("TIFF, %s", async (_, type, form) => {
    const file = tiffOf({ width, height, ...form }, voxelsOf(type, sizes));
    await compare(newFolder({ "a.tif": file }), "a.tif");
  });

  /** A series of slices, with their transfer syntax in the header. */
  const series = (syntax?: string): Record<string, Uint8Array> => {
    const voxels = new Uint16Array(voxelsOf("uint16", sizes).buffer);
    const slice = width * height;
    return Object.fromEntries(
      Array.from({ length: 12 }, (_, z) => {
        const pixels = voxels.subarray(z * 5 * slice, (z * 5 + 1) * slice);
        return [`ct/${z}.dcm`, dicomSlice(pixels, width, z, syntax)];
      }),
    );
  };

  test("a DICOM series of run lengths", async () => {
    await compare(newFolder(series()), "ct");
  });

  test("a DICOM series of a transfer syntax that browsers do not decode names the program", async () => {
    const inside = newFolder(series("1.2.840.10008.1.2.4.90"));
    expect(await buildHere(inside, "ct", {})).toMatch(
      /transfer syntax 1\.2\.840\.10008\.1\.2\.4\.90: .*isosplat build/,
    );
  });

  test("one segment of a DICOM segmentation, or the list of all", async () => {
    const frames = [1, 2].flatMap((segment) =>
      [0, 1, 2, 5, 6].map((z) => ({
        segment,
        z,
        pixels: Array.from({ length: 11 * 9 }, (_, i) => Number((i + z) % (segment + 2) === 0)),
      })),
    );
    const inside = newFolder({ "a.dcm": dicomSegmentation(frames, 11, 9) });
    await compare(inside, "a.dcm", ["--segment", "part 2"], { segment: "part 2" });
    await compare(inside, "a.dcm");
    expect(await buildHere(inside, "a.dcm", {})).toMatch(/--segment 1 or "part 1", 5 frames/);
    const reader = await localImporter(programs.importer, filesOf(inside));
    let error: unknown;
    try {
      reader.open("a.dcm");
    } catch (thrown) {
      error = thrown;
    }
    expect(error).toBeInstanceOf(ChoiceError);
    expect((error as ChoiceError).choices).toEqual([
      { label: 'segment 1 ("part 1")', name: "part 1", options: { segment: "1" } },
      { label: 'segment 2 ("part 2")', name: "part 2", options: { segment: "2" } },
    ]);
  });

  test.skipIf(!existsSync(join(volumes, "cthead_tif")))("a folder of TIFF slices", async () => {
    const inside = newFolder({ "none.txt": "" });
    cpSync(join(volumes, "cthead_tif"), join(inside, "ct"), { recursive: true });
    await compare(inside, "ct", ["--spacing", "1,1,2"], { spacing: [1, 1, 2] });
  });

  const real = existsSync(volumes)
    ? readdirSync(volumes).filter((name) => /\.(nhdr|nrrd|nii\.gz|vtk)$/.test(name))
    : [];
  // The largest takes 20 s on two idle cores.
  test.each(real)("%s, of the real volumes", { timeout: 180_000 }, async (name) => {
    const inside = newFolder({ "none.txt": "" });
    copyFileSync(join(volumes, name), join(inside, name));
    const raw = name.replace(/nhdr$/, "raw.gz");
    if (raw !== name) copyFileSync(join(volumes, raw), join(inside, raw));
    await compare(inside, name);
  });

  // Compressed files are unpacked by a worker of the page: tests/browser. Zarr is read from addresses.
  const described = existsSync(cases)
    ? readdirSync(cases).filter((name) => !/\.(md|bz2|zarr)$/.test(name))
    : [];
  test.each(described)("%s, a file that describes itself", async (name) => {
    const inside = newFolder({ "none.txt": "" });
    cpSync(join(cases, name), join(inside, name), { recursive: true });
    await compare(inside, name);
  });

  // The largest of these volumes: slow beside other programs.
  test.skipIf(!existsSync(join(volumes, "mr_t1_dicom")))(
    "a DICOM series",
    {
      timeout: 120_000,
    },
    async () => {
      const inside = newFolder({ "none.txt": "" });
      cpSync(join(volumes, "mr_t1_dicom"), join(inside, "mr"), { recursive: true });
      await compare(inside, "mr");
    },
  );
});

describe("faults have the program's words", () => {
  const voxels = voxelsOf("uint8", [10, 10, 10]);
  const header = nrrd("uint8", [10, 10, 10], "encoding: raw\n");
  const zipped = nrrd("uint8", [10, 10, 10], "encoding: gzip\n");
  const join2 = (a: string, b: Uint8Array): Buffer => Buffer.concat([Buffer.from(a), b]);
  const damaged = gzipSync(voxels);
  damaged[damaged.length - 6] = 255 ^ (damaged[damaged.length - 6] as number);
  const cases: Record<string, Record<string, string | Uint8Array>> = {
    "voxels are missing": { "a.nrrd": join2(header, voxels.subarray(1)) },
    "voxels are left over": { "a.nrrd": join2(header, Buffer.alloc(1001)) },
    "a gzip checksum is wrong": { "a.nrrd": join2(zipped, damaged) },
    "gzip data end early": { "a.nrrd": join2(zipped, gzipSync(voxels).subarray(0, 30)) },
    "nothing is known about the file": { "a.nrrd": Buffer.alloc(5000, 7) },
    "the file is empty": { "a.nrrd": "" },
    "the header is cut off": { "a.nrrd": header.slice(0, 40) },
    "the volume is flat": { "a.nrrd": nrrd("uint8", [10, 10, 1], "encoding: raw\n") },
    "sizes are enormous": {
      "a.nrrd": nrrd("double", [1048576, 1048576, 1048576], "encoding: gzip\n"),
    },
    "the type is unknown": { "a.nrrd": nrrd("block", [10, 10, 10], "encoding: raw\n") },
  };
  test.each(Object.keys(cases))("%s", async (name) => {
    await compare(newFolder(cases[name] as Record<string, string>), "a.nrrd");
  });

  const stack: TiffForm = { width: 10, height: 10, bits: 8, format: 1 };
  const tiff = Buffer.from(tiffOf(stack, voxels));
  const changed = (at: number, byte: number): Buffer => {
    const bytes = Buffer.from(tiff);
    bytes[at] = byte;
    return bytes;
  };
  const { length } = tiff;
  const tiffCases: Record<string, Buffer> = {
    "the last page is cut off": tiff.subarray(0, length - 20),
    "only the header is left": tiff.subarray(0, 8),
    "the list of pages is a cycle": changed(length - 4, tiff[4] as number),
    "a page has another size": changed(length - 4 - 12 * 10 + 8, 11),
    "voxels are outside of the file": changed(length - 4 - 12 * 5 + 10, 200),
    "the description counts more pages": Buffer.from(
      tiffOf({ ...stack, description: "ImageJ=1.53t\nimages=20\nslices=20\n" }, voxels),
    ),
    "a page has 24 bits per voxel": changed(length - 4 - 12 * 8 + 8, 24),
  };
  test.each(Object.keys(tiffCases))("TIFF: %s", async (name) => {
    await compare(newFolder({ "a.tif": tiffCases[name] as Buffer }), "a.tif");
  });

  test("TIFF with a compression that browsers do not decode names the program", async () => {
    const inside = newFolder({ "a.tif": tiffOf({ ...stack, compression: 7 }, voxels) });
    expect(await buildHere(inside, "a.tif", {})).toMatch(
      /JPEG compression \(7\).*isosplat build a\.tif/,
    );
  });

  test("a volume that is too large is refused before it is read", async () => {
    // Volumes that need too much memory, with slices of 2^32 bytes and of fewer.
    for (const sizes of [
      [65536, 65536, 3],
      [30000, 30000, 30],
      [2000, 2000, 2000],
    ] as const) {
      const header = nrrd("uint8", sizes, "encoding: raw\n");
      const bytes = header.length + sizes[0] * sizes[1] * sizes[2];
      const file = sparseFile("a.nrrd", Buffer.from(header), bytes);
      const reader = await localImporter(programs.importer, [file]);
      const read = async (): Promise<unknown> => {
        const never = (): never => expect.fail("it was read");
        return buildLocally(programs.builder, programs.encoders, reader.open("a.nrrd"), never);
      };
      await expect(read()).rejects.toThrow(/isosplat build/);
    }
  });

  test("hostile bytes end in an error, never in a crash of the page", async () => {
    const good: Uint8Array[] = Object.values(cases).map((files) =>
      Buffer.from(files["a.nrrd"] as string),
    );
    let random = 7;
    const next = (limit: number): number => {
      random = (Math.imul(random, 1664525) + 1013904223) >>> 0;
      return Math.floor((random / 2 ** 32) * limit);
    };
    for (let i = 0; i < 300; ++i) {
      const bytes = Uint8Array.from(good[next(good.length)] as Uint8Array);
      for (let flips = next(5); flips > 0 && bytes.length > 0; --flips) {
        bytes[next(Math.min(200, bytes.length))] = next(256);
      }
      const reader = await localImporter(programs.importer, [fileOf("a.nrrd", bytes)]);
      try {
        const { voxels: n, type } = reader.open("a.nrrd");
        const slice = (n[0] * n[1] * Number(type.slice(1))) / 8;
        if (slice < 1e6) reader.readSlices(0, 1, new Uint8Array(slice));
      } catch (error) {
        expect(error).toBeInstanceOf(CoreError);
      }
    }
  });
});

describe("volumes are found among files", () => {
  const find = async (files: Record<string, string | Uint8Array>) => {
    const inputs = Object.entries(files).map(([path, content]) =>
      fileOf(path, Buffer.from(content as string)),
    );
    const reader = await localImporter(programs.importer, inputs);
    return volumesAmong(
      inputs,
      (path) => reader.detect(path),
      (path) => reader.choices(path),
    );
  };
  const header = nrrd("uint8", [2, 2, 2], "encoding: raw\ndata file: a.raw\n");

  test("a header with its data, but no unrelated files", async () => {
    expect(await find({ "a.nhdr": header, "a.raw": "12345678", "b.txt": "no" })).toMatchObject([
      { path: "a.nhdr", format: "NRRD", files: 2, needsDims: false },
    ]);
    const unrelated = Array.from({ length: 100 }, (_, i) => [`photo${i}.jpg`, "\xff\xd8 no"]);
    expect(await find(Object.fromEntries(unrelated))).toEqual([]);
  });

  test("series of DICOM, with what their files say of them", async () => {
    const plain = "1.2.840.10008.1.2.5";
    const slices = (folder: string, uid: string, date: string, description: string) =>
      [0, 1, 2].map((z): [string, Uint8Array] => {
        const series = { uid, date, description };
        const pixels = new Uint16Array(12).fill(z);
        return [`${folder}/${uid}-${z}.dcm`, dicomSlice(pixels, 4, z, plain, series)];
      });
    const thorax = slices("a", "1.2.3", "20110305", "Thorax");
    const knee = slices("b", "1.2.4", "20120406", "Knee");
    const undated = slices("b", "1.2.5", "", "");
    const textsOf = async (...files: [string, Uint8Array][]) => {
      const found = await find(Object.fromEntries(files));
      return found.map(({ path, name, choice }) => [path, name ?? choice?.label]);
    };
    expect(await textsOf(...thorax)).toEqual([["a", undefined]]);
    expect(await textsOf(...thorax, ...knee)).toEqual([
      ["a", 'CT, 4 × 3 × 3, "Thorax", 2011-03-05'],
      ["b", 'CT, 4 × 3 × 3, "Knee", 2012-04-06'],
    ]);
    expect(await textsOf(...thorax, ...knee, ...undated)).toEqual(
      expect.arrayContaining([
        ["b", 'series 1: CT, 4 × 3 × 3, "Knee", 2012-04-06'],
        ["b", "series 2: CT, 4 × 3 × 3"],
      ]),
    );
  });

  test("raw files, with and without dimensions in their names", async () => {
    expect(await find({ "x/a.raw": "123", "y/b_2x2x2_uint8.raw": "12345678" })).toMatchObject([
      { path: "y/b_2x2x2_uint8.raw", format: "raw", needsDims: false },
      { path: "x/a.raw", format: "raw", needsDims: true },
    ]);
  });
});

test("the module takes at most 318 KB on the network", () => {
  const wasm = readFileSync(join(root, "build/wasm/web/isosplat-import.wasm"));
  expect(brotliCompressSync(wasm).byteLength).toBeLessThan(318_000);
});
