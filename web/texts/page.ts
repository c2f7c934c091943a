import { plurals } from "./numbers.ts";
import { part } from "./part.ts";

const plural = plurals("en");

/** What is there from the beginning: around the picture, below it, and messages. */
export const pageTexts = part("page", {
  home: "Isosplat: all volumes",
  lightTheme: "Light theme",
  darkTheme: "Dark theme",
  language: "Language",
  onThisServer: "Volumes on this server",
  again: "Try again",
  loadAnew: "Load the page anew",
  allVolumes: "All volumes",
  details: "Details",
  incomplete:
    "A part of this page did not load: the connection failed, or the page was updated on its server. It is requested again.",
  reload: "Reload",
  dismiss: "Close",

  reset: "Reset the view",
  savePicture: "Save a picture",
  copyLink: "Copy a link to this view",
  shareLink: "Share a link to this view",
  keys: "Keys and gestures",
  controls: "Controls",
  fewer: "Fewer controls",
  more: "More controls",
  view3d: "3D view",
  picture: (volume: string, isovalues: string) =>
    `Isosurface of ${volume} at ${isovalues}. Arrow keys rotate it, plus and minus zoom.`,

  voxels: (text: string, voxels: number) =>
    `${text} ${plural(voxels, { one: "voxel", other: "voxels" })}`,
  nothingThere: "There is no layer with a name in the middle of the picture.",
  linkCopied: "Link copied",
  /** names: of volumes, with commas. */
  linkNeedsFile: (names: string) =>
    `It has the view, not the volume, which is on this device alone: whoever opens it needs the same file (“${names}”).`,
  linkOfThisComputer:
    "It works on this computer only: its server has an address that other computers do not reach.",
  noLinkOfFile:
    "A page that was opened from a file has no link for others. Send them the file itself.",
  noLinkOfScene:
    "A scene that was opened from this device has no link. Send its file, or save it as a single page.",
  noSharing: "The system of this device did not take the link: copy it instead",
  noClipboard: "The browser does not allow access to the clipboard: copy the address bar instead",
  pictureSaved: "Picture saved",
  noPicture: "There is no picture yet",
  replaced: "The volume was replaced on its server: this is the new version.",
  layerMissing: (name: string, reason: string) => `Layer ${name} cannot be shown: ${reason}.`,
  allHidden: (name: string) =>
    `${name}: expected a visible layer, found none: show one in its list.`,
  viewTooFar: "The view in the address is too far from the volume: the default view is shown.",
  isovaluesOutside: (isovalues: string, low: string, high: string) =>
    `The address contains isovalue ${isovalues}, but the volume's values are ${low} to ${high}.`,
  noHandles:
    "The handles of the clip box could not be loaded: the connection failed. Open the section again.",
  noSection: "The section could not be loaded: the connection failed. Open it again.",
  noMeasuring: "Measuring could not be loaded: the connection failed. Try again.",
  savedUnmoved:
    "The surface is saved in the coordinates of its own volume: the layer is shown elsewhere.",
  noSaving: "Saving could not be loaded: the connection failed. Try again.",
  spacingUnchanged:
    "The volume could not be opened with other distances between voxels: nothing was changed.",
  noDialog: "The dialog could not be loaded: the connection failed. Try again.",

  ignored: (setting: string, expected: string) =>
    `“${setting}” in the address was ignored: expected ${expected}.`,
  invisible: (percent: string) =>
    `The address contains an invisible surface: it is shown at ${percent} %.`,
  isSpacing: "three numbers above 0, in mm",
  isNumbers: "numbers, such as 60.5,180",
  isNumber: "a number",
  isAboveZero: "a number above 0",
  isColours: "colours such as d9ccb3",
  isColour: "a colour such as ffffff",
  linesEvery: (interval: string) => `Lines every ${interval}`,
  linesPerDecades: (count: string, isOne: boolean) =>
    isOne ? "Lines every decade" : `Lines every ${count} decades`,
  logarithmic: (quantity: string) => `${quantity}, logarithmic`,
  noFieldValue: (field: string) => `${field}: no value`,
  isFieldName: "the name of a field",
  isShares: "numbers from 0 to 1",
  isShare: "a number from 0 to 1",
  isBox: "x0,x1,y0,y1,z0,z1 from 0 to 1",
  isParts: (parts: string) => `none, or some of ${parts}`,
  isEither: (one: string, other: string) => `${one} or ${other}`,
  /** ranges: "0 to 1, 0 to 2" */
  isInRanges: (ranges: string) => `numbers: ${ranges}`,

  status: "Status",
  samplesTitle: "Samples drawn in the last frame",
  samples: (count: string) => `${count} samples`,
  bytesTitle: "Payload fetched since the volume was opened",
  fetched: (bytes: string) => `${bytes} fetched`,
  levelTitle: "Level of detail shown; 0 is the volume itself",
  fullResolution: "full resolution",
  level: (level: number) => `level ${level}`,
  levels: (finest: number, coarsest: number) => `levels ${finest}–${coarsest}`,
  framesTitle: "Frames per second while the view moves",
  frames: (perSecond: number) => `${perSecond} fps`,
  stateTitle: "What is left to fetch for this view",
  toGo: (bytes: string) => `${bytes} to go`,
  complete: "complete",
  quick: "quick picture",
  quickTitle:
    "This device draws slowly: smooth edges and shadows are left out, except in saved pictures",
  noSurface: "complete: no surface in this view",
  clipped: "complete: a part is clipped away",
  noSurfaceLeft: "complete: no surface in this view, where a part is clipped away",
  limited: "limited by memory",
  opening: "opening",
  serverError: "server error, trying again",
  offline: "offline, trying again",
  refining: "refining",
  missing: "parts are missing",
  damaged: (n: number) =>
    `complete except for ${plural(n, { one: `${n} damaged part`, other: `${n} damaged parts` })}`,
  preparing: (bytes: string, planned: string) =>
    `preparing other isovalues, ${bytes} of ${planned}`,

  near: "near",
  far: "far",
  left: (time: string) => `${time} left`,
  perLength: (units: string) => `${units ? `${units} ` : ""}per unit length`,
  cells: "cells",
  colours: (name: string, low: string, high: string, units: string) =>
    `Colours: ${name}, ${low} to ${high} ${units}`,
  histogram: "Histogram of the volume's values, and the active cells of each isovalue",
  to: (low: string, high: string) => `${low} to ${high}`,
  notPerpendicular: (degrees: string) => `not perpendicular: ${degrees}° off`,
  bits: (bits: number) => `${bits} bit`,
  signed: (bits: number) => `${bits} bit signed`,
  float: (bits: number) => `${bits} bit float`,
});
