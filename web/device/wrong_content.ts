/** What a file contains that is no volume, by its first bytes. */
export type WrongContent =
  | { kind: "empty" }
  | { kind: "webPage" }
  /** `beginning`: its first words. */
  | { kind: "text"; beginning: string };

/** The number of first bytes that are read. */
const readBytes = 4096;
/** The number of letters of a text's beginning. */
const mostLetters = 40;

/** Undefined: neither empty nor text. */
export async function wrongContent(file: Blob): Promise<WrongContent | undefined> {
  if (file.size === 0) return { kind: "empty" };
  const text = textOf(new Uint8Array(await file.slice(0, readBytes).arrayBuffer()));
  if (text === undefined) return undefined;
  if (/^<(!doctype html|html|head|body)\b/i.test(text)) return { kind: "webPage" };
  const line = text.split(/[\r\n]/, 1)[0] ?? "";
  const letters = [...line];
  const isCut = letters.length > mostLetters || line.length < text.length;
  const beginning = letters.slice(0, mostLetters).join("").trimEnd();
  return { kind: "text", beginning: isCut ? `${beginning}…` : beginning };
}

/** How the core describes a text that it does not know: shared/import/known_files.cpp. */
const unknownText = "found a text that begins with";

/**
 * The content of a file that could not be opened, if it is a text that the core does not know. Of other texts,
 * such as meshes and headers, the core's error says what they are, and what to do.
 */
export async function unknownTextOf(error: unknown, file: Blob): Promise<WrongContent | undefined> {
  if (!(error instanceof Error && error.message.includes(unknownText))) return undefined;
  return wrongContent(file);
}

/** Without white space at its ends. Undefined if the bytes are no text. */
function textOf(bytes: Uint8Array): string | undefined {
  const isUtf16 =
    (bytes[0] === 0xff && bytes[1] === 0xfe) || (bytes[0] === 0xfe && bytes[1] === 0xff);
  const encoding = !isUtf16 ? "utf-8" : bytes[0] === 0xff ? "utf-16le" : "utf-16be";
  try {
    // A letter may be cut at the end of the bytes that were read.
    const text = new TextDecoder(encoding, { fatal: true }).decode(bytes, { stream: true }).trim();
    const hasControls = [...text].some((letter) => letter < " " && !"\t\n\r\f".includes(letter));
    return hasControls ? undefined : text;
  } catch {
    return undefined; // other bytes
  }
}

const formats: Record<string, string> = {
  ...{ nrrd: "NRRD", nhdr: "NRRD", mha: "MetaImage", mhd: "MetaImage", nii: "NIfTI" },
  ...{ mgh: "MGH", mgz: "MGH", mrc: "MRC", map: "MRC", rec: "MRC", npy: "NumPy", npz: "NumPy" },
  ...{ h5: "HDF5", hdf5: "HDF5", nc: "netCDF", dcm: "DICOM", tif: "TIFF", tiff: "TIFF" },
  ...{ vtk: "VTK", vti: "VTK", vtu: "VTK", vtr: "VTK", vts: "VTK", cube: "cube", xsf: "XSF" },
  ...{ dx: "OpenDX", isosplat: "Isosplat" },
};

/** The format that a file's name states: "NRRD"; undefined if it states none. */
export function formatOfName(path: string): string | undefined {
  const ending = /\.([a-z0-9]+)(\.gz)?$/i.exec(path)?.[1]?.toLowerCase() ?? "";
  return Object.hasOwn(formats, ending) ? formats[ending] : undefined;
}
