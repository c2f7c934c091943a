import { part } from "./part.ts";

/** The dialog that saves a surface as triangles. */
export const surfaceTexts = part("surface", {
  title: "Save the surface",
  lead: (isovalue: string) => `The isosurface at ${isovalue} as triangles.`,
  format: "Format",
  formats: {
    stl: "STL, for printing",
    glb: "GLB, for 3D programs and the web",
    ply: "PLY, for MeshLab, CloudCompare and VTK",
  },
  detail: "Detail",
  full: (cells: string) => `Full: ${cells} cells`,
  level: (level: number, cells: string) => `Level ${level}: ${cells} cells`,
  closed: "Closed: with faces where the volume ends and where it is clipped",
  clipped: "Only what is inside of the clipping",
  wholeCells:
    "Only what is inside of the clipping box, in whole cells: the border has steps of a voxel",
  planesNeedClosed:
    "The file will not be cut by oblique planes, which cut only a closed surface. “Closed” may need full detail.",
  openAtLevel:
    "At less than full detail the surface is saved open, unless you choose “Closed”, for which it may need full detail.",
  mayNeedFull: "Closing may need full detail: at this level, lost details can leave holes.",
  holesOfLevel:
    "Not saved: the surface cannot be closed at this level, where lost details leave holes in it.",
  holesOfMissing:
    "Not saved: the surface cannot be closed, because missing voxels leave holes in it.",
  chooseFull: "Choose full detail",
  leaveOpen: "Leave it open",
  /** By the unit of the volume and the format of the file. */
  lengths: {
    mm: {
      stl: "STL files state no unit: lengths are those of the volume, in millimetres.",
      ply: "PLY files state no unit: lengths are those of the volume, in millimetres.",
      glb: "Lengths are those of the volume, in metres, as GLB files have them.",
    },
    voxel: {
      stl: "The volume's file states no distance between voxels: lengths are in voxels. Programs for printing take a voxel for 1 mm.",
      ply: "The volume's file states no distance between voxels: lengths are in voxels.",
      glb: "The volume's file states no distance between voxels: a voxel has 1 mm in this file.",
    },
  },
  saving: "Saving the surface",
  save: "Save",
  cancel: "Cancel",
  cancelled: "Cancelled",
  saved: (triangles: string, bytes: string) => `Saved: ${triangles} triangles, ${bytes}`,
  leftOpen: "It is open: missing voxels leave holes in it.",
  tooLarge: (millions: number) =>
    `expected a surface that fits into the browser's memory and into 4 GB, found about ${millions} million cells: choose a coarser level, clip the volume, or use isosplat extract --mesh`,
  nothing: "There is no surface here: choose another isovalue or a larger box.",
  about: (triangles: string, bytes: string) => `About ${triangles} triangles, ${bytes}.`,
  atMost: (triangles: string, bytes: string) => `At most about ${triangles} triangles, ${bytes}.`,
  cost: (bytes: string, time: string) => `Reads ${bytes}, and computes for about ${time}.`,
  aSecond: "a second",
  seconds: (n: number) => `${n} seconds`,
});
