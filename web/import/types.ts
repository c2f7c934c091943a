import type { VolumeDescription, VoxelType } from "../builder/types.ts";
import { CoreError } from "../core/calls.ts";

/** A file that was dropped or chosen. */
export interface InputFile {
  /** Relative, with "/" between its parts: "scan/IM0001.dcm". The files of one drop share the root. */
  path: string;
  file: Blob;
}

/** The options of `isosplat build` that concern reading: ImportOptions in shared/import/volume/import_options.h. */
export interface ImportOptions {
  /** Raw files only: voxels along x, y and z. */
  dims?: readonly [number, number, number];
  /** Raw files only. */
  type?: VoxelType;
  /** Raw files only. Default: little-endian, with a note. */
  bigEndian?: boolean;
  /** Raw files only: bytes before the first voxel. */
  skipBytes?: number;
  /** Overrides the spacing of the file, in millimetres. */
  spacing?: readonly [number, number, number];
  /** A time step of a 4D volume, from 0. */
  timeStep?: number;
  /** DICOM: a series, by its number in messages or its UID. TIFF: an image, by its number or name. */
  series?: string;
  /** DICOM segmentations: a segment, by its number or label. */
  segment?: string;
  /** A channel of a volume with several, from 0. */
  channel?: number;
  /** HDF5: the path of a dataset. .npz: the name of an array. */
  dataset?: string;
  /** Faults of the file to accept. */
  allow?: readonly ("gaps" | "truncated" | "surplus" | "unplaced" | "frames")[];
  /**
   * Voxels of this value are missing; "none": no value means missing. Default: determined by the
   * importer.
   */
  missingValue?: number | "none";
}

/** How a file is compressed as a whole. */
export type Packing = "gzip" | "bzip2" | "xz" | "zstd";

/** One of several volumes in a file, or (`allow`) a fault of a file that can be accepted. */
export interface VolumeChoice {
  /** Distinguishes it from the others: "/image", "series 2, channel 0 (DAPI)". */
  label: string;
  /** Its name in the file, and sizes. */
  name?: string;
  options: Pick<ImportOptions, "dataset" | "series" | "segment" | "channel" | "timeStep" | "allow">;
}

/**
 * A file has several volumes, and the options choose none. To choose one, add the options of one of
 * `choices`. A further choice may follow.
 */
export class ChoiceError extends CoreError {
  readonly choices: readonly VolumeChoice[];
  constructor(status: string, detail: string, choices: readonly VolumeChoice[]) {
    super(status, detail);
    this.choices = choices;
  }
}

/** A volume among files, by their names and first bytes. */
export interface VolumeCandidate {
  /** The argument `path` of openVolume: a file, or a folder of slices; "." is the root. */
  path: string;
  /**
   * "NRRD", "MetaImage", "NIfTI", "MGH", "MRC", "NumPy", "NumPy archive", "HDF5", "netCDF", "VTK",
   * "VTK XML", "cube", "VASP", "XSF", "OpenDX", "TIFF", "PNG", "JPEG", "JPEG 2000", "DICOM", "raw" or
   * "compressed". The format inside a compressed file is known only when it is opened.
   */
  format: string;
  /** One of the volumes of a file with several. */
  choice?: VolumeChoice;
  /** What the file says of its volume, such as modality, size, description and date. */
  name?: string;
  /** The number of files that belong to it according to their names, and their bytes. */
  files: number;
  bytes: number;
  /** A raw file whose name lacks dimensions or type: openVolume needs `dims` and `type`. */
  needsDims: boolean;
}

/** The importer's description of an open volume. */
export interface ImportedVolume extends VolumeDescription {
  notes: string[];
  /** Paths of all files that the volume is read from. */
  files: string[];
  /** The memory that reading takes, besides the slices. */
  residentBytes: number;
  /** All volumes, if the files have several and one was chosen without an option. */
  choices?: VolumeChoice[];
}
