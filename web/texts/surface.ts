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
  millimetres: "STL files state no unit: lengths are those of the volume, in millimetres.",
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
