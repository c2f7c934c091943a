import { plurals } from "./numbers.ts";
import { part } from "./part.ts";

const plural = plurals("en");

/** Measuring: the section of the panel, and what lies above the picture. */
export const measureTexts = part("measure", {
  kinds: { point: "Point", distance: "Distance", path: "Path", angle: "Angle", note: "Note" },
  hints: {
    point: "Click on the surface.",
    distance: "Click two points of the surface.",
    path: "Click the points of the path, then Done.",
    angle: "Click three points: the second is the corner.",
    note: "Click where the note belongs.",
  },
  keys: "Enter takes the middle of the picture, Escape ends.",
  pathKeys: "Enter takes the middle of the picture, Shift + Enter is Done, Escape ends.",
  done: "Done",
  end: "End",
  endMeasuring: "End measuring",
  missed: "There is no surface at that place.",
  tooMany: (measurements: number, points: number) =>
    `There are ${measurements} measurements, or ${points} points: remove some first.`,
  newNote: (number: number) => `Note ${number}`,

  measure: "Measure",
  measurements: "Measurements",
  noAngle: "no angle",
  coarse: "From coarse cells: come closer to measure exactly.",
  at: (position: string) => `at ${position}`,
  voxel: (voxel: string) => `voxel ${voxel}`,
  value: (value: string) => `value ${value}`,
  normal: (normal: string) => `normal ${normal}`,
  onLayers: (layers: string) => `on ${layers}`,
  ofLevel: (level: number) => `from cells of level ${level}: come closer to measure exactly`,
  pointsSet: (n: number) =>
    n === 0 ? "No point set" : plural(n, { one: `${n} point set`, other: `${n} points set` }),
  count: (n: number) =>
    n === 0
      ? "No measurements"
      : plural(n, { one: `${n} measurement`, other: `${n} measurements` }),
  isRemoved: (name: string) => `${name} removed`,
  again: "Again",
  againNamed: (name: string) => `Measure ${name} again`,
  againTitle: "Measures it again, with its text. Points in the picture can also be dragged.",
  remove: "Remove",
  removeNamed: (name: string) => `Remove ${name}`,
  text: "Text",
  textOf: (name: string) => `Text of ${name}`,
  extentTitle:
    "Measures the whole isosurface by triangles at full detail; this reads the stated number of bytes",
  extent: "Area and volume",
  stop: "Stop",
  isovalue: (isovalue: string) => `Isovalue ${isovalue}`,
  area: "area",
  volume: "volume of greater values",
  holes: "no volume: the surface has holes where voxels are missing",

  copyAndSave: "Copy and save",
  copy: "Copy",
  removeAll: "Remove all",
  saveSession: "Save session",
  saveSessionTitle: "View and measurements in a file: drop it on this page to open it",
  copied: "Measurements copied",
  noClipboard: "The browser does not allow access to the clipboard: save them instead",
  ignored: (count: number, all: number) =>
    `${count} of ${all} measurements in the address were ignored: expected kind,x,y,z.`,
  otherVersion:
    "The measurements are of another version of this volume: its surfaces may lie elsewhere.",
  isDistorted: "not measured: the layer is stretched or sheared",
  notInAddress:
    "The measurements and layers do not fit into the address: links have less. Save a session to share them.",
});
