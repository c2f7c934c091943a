import type { StoreInfo, Triple } from "../core/types.ts";

/** The formats of files. Their indices are their numbers in the module (MeshFormatId). */
export const meshFormats = ["stl", "ply", "glb"] as const;
export type MeshFormat = (typeof meshFormats)[number];

/** The part of a volume within a box, in fractions of its extent along each axis of its grid. */
export interface GridBox {
  low: Readonly<Triple>;
  high: Readonly<Triple>;
}

/** The points with normal · point ≥ offset, in the world. */
export interface HalfSpace {
  normal: Readonly<Triple>;
  offset: number;
}

/** An isosurface as a file. */
export interface FileJob {
  kind: "file";
  info: StoreInfo;
  quantizedIsovalue: number;
  level: number;
  format: MeshFormat;
  /** One line for the file's header. */
  comment: string;
  /** Closed: only what is in the box. Open: only cells whose centres are in it. */
  box?: GridBox;
  /** Whether the surface is closed: at the volume's border, and where box and planes cut it. */
  closed: boolean;
  /** Only for closed surfaces. */
  planes: readonly HalfSpace[];
}

/** Area and volume of an isosurface, at full detail. */
export interface ExtentJob {
  kind: "extent";
  info: StoreInfo;
  quantizedIsovalue: number;
}

export type MeshJob = FileJob | ExtentJob;

/** The result of a job: see isosplat_mesh_summary. `file`: of a FileJob. */
export interface MeshResult {
  numbers: readonly [number, number, number];
  file?: Blob;
}
