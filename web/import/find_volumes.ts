import type { InputFile, VolumeCandidate, VolumeChoice } from "./types.ts";

/** The largest number of files whose first bytes are read. */
const maxDetected = 2000;
/**
 * If none of this number of files in a folder is a recognizable slice, the rest of the folder is not
 * read.
 */
const maxUnknown = 20;

const headerFormats = [
  "NRRD",
  "MetaImage",
  "NIfTI",
  "MGH",
  "MRC",
  "NumPy",
  "NumPy archive",
  "HDF5",
  "netCDF",
  "VTK",
  "VTK XML",
  "cube",
  "VASP",
  "XSF",
  "OpenDX",
  "compressed",
];
/** A folder of these is a volume; a single file is a picture. */
const imageFormats = ["PNG", "JPEG", "JPEG 2000"];
/** Names of files that may lie beside volumes, but are never volumes. */
const ignored =
  /(^|\/)(\.[^/]*|Thumbs\.db|DICOMDIR|LICENSE[^/]*|README[^/]*)$|\.(isosplat|txt|md|json|pdf|html?)$/i;

function folderOf(path: string): string {
  const cut = path.lastIndexOf("/");
  return cut < 0 ? "." : path.slice(0, cut);
}

/** The name without the part that data files append to the name of their header. */
function stem(path: string): string {
  return path.replace(/\.(gz|bz2|xz|zst)$/i, "").replace(/\.[^./]*$/, "");
}

/**
 * Finds the volumes among files: files with a header, folders of slices, and raw files, the largest
 * first. `detect` returns the format of a file by its first bytes. `choices` returns the volumes of a
 * file with several.
 */
export function volumesAmong(
  files: readonly InputFile[],
  detect: (path: string) => string,
  choices: (path: string) => readonly VolumeChoice[],
): VolumeCandidate[] {
  const folders = new Map<string, InputFile[]>();
  for (const input of files) {
    if (ignored.test(input.path)) continue;
    const folder = folderOf(input.path);
    folders.set(folder, [...(folders.get(folder) ?? []), input]);
  }
  const found: VolumeCandidate[] = [];
  const series: VolumeCandidate[] = []; // of DICOM
  let detected = 0;
  for (const [folder, inside] of folders) {
    const slices: InputFile[] = [];
    const raws: InputFile[] = [];
    const headers: InputFile[] = [];
    let sliceFormat = "";
    let unknown = 0;
    for (const input of inside) {
      if (detected++ >= maxDetected || unknown > maxUnknown) break;
      // All files of a folder of slices have one format, so the first ones decide.
      const isSlice = slices.length >= 8 && sliceFormat !== "";
      const format = isSlice ? sliceFormat : detect(input.path);
      if (headerFormats.includes(format)) {
        headers.push(input);
        const { path } = input;
        const volume = { path, format, files: 1, bytes: input.file.size, needsDims: false };
        found.push(...eachOf(volume, choices(path)));
      } else if (format === "DICOM" || format === "TIFF" || imageFormats.includes(format)) {
        sliceFormat ||= format;
        slices.push(input);
      } else if (format === "raw") raws.push(input);
      else if (format === "") unknown++;
    }
    if (slices.length > (imageFormats.includes(sliceFormat) ? 1 : 0)) {
      const [first] = slices as [InputFile];
      const volume = {
        path: slices.length === 1 ? first.path : folder,
        format: sliceFormat,
        files: slices.length,
        bytes: slices.reduce((sum, { file }) => sum + file.size, 0),
        needsDims: false,
      };
      if (sliceFormat === "DICOM") series.push(volume);
      else found.push(...eachOf(volume, choices(volume.path)));
    }
    for (const input of raws) {
      const header = headers.find(({ path }) => stem(path) === stem(input.path));
      const owner = header && found.find(({ path }) => path === header.path);
      if (owner) {
        owner.files++;
        owner.bytes += input.file.size;
      } else if (headers.length === 0 || !folderHasDetached(headers)) {
        const needsDims = !/\d+x\d+x\d+/i.test(input.path);
        const { size: bytes } = input.file;
        found.push({ path: input.path, format: "raw", files: 1, bytes, needsDims });
      }
    }
  }
  // The names of DICOM's files say little. A single folder is opened without reading all of them twice.
  const isOnly = found.length === 0 && series.length === 1;
  found.push(...(isOnly ? series : series.flatMap((each) => described(each, choices(each.path)))));
  return withPieces(found).sort(
    (a, b) => Number(a.needsDims) - Number(b.needsDims) || b.bytes - a.bytes,
  );
}

/**
 * Adds the bytes of pieces to the .pvti or .pvtr file that names them. VTK writes the pieces of
 * "a.pvti" to "a_0.vti", ParaView to "a/a_0.vti".
 */
function withPieces(found: VolumeCandidate[]): VolumeCandidate[] {
  const wholes = found.filter(({ path }) => /\.pvt[ir]$/i.test(path));
  return found.filter((piece) => {
    const start = (path: string) => piece.path.slice(stem(path).length);
    const whole = wholes.find(
      ({ path }) => piece.path.startsWith(stem(path)) && /^[_/].*\.vt[ir]$/i.test(start(path)),
    );
    if (!whole) return true;
    whole.files++;
    whole.bytes += piece.bytes;
    return false;
  });
}

/** A file's volume, or each of its volumes. */
function eachOf(volume: VolumeCandidate, several: readonly VolumeChoice[]): VolumeCandidate[] {
  return several.length < 2 ? [volume] : several.map((choice) => ({ ...volume, choice }));
}

/** Each series of a DICOM volume, with its description. */
function described(volume: VolumeCandidate, all: readonly VolumeChoice[]): VolumeCandidate[] {
  const [only] = all;
  return all.length === 1 && only
    ? [{ ...volume, ...(only.name && { name: only.name }) }]
    : eachOf(volume, all);
}

/** Whether some header refers to other files for its voxels, which may be the raw files beside it. */
function folderHasDetached(headers: readonly InputFile[]): boolean {
  return headers.some(({ path }) => /\.(nhdr|mhd|hdr)$/i.test(path));
}
