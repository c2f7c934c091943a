import { plurals } from "./numbers.ts";
import { part } from "./part.ts";

const plural = plurals("en");

/** The dialog of pictures and films. */
export const captureTexts = part("capture", {
  title: "Pictures and films",
  what: "What",
  whats: {
    picture: "Picture",
    turntable: "Film: once around",
    sweep: "Film: through isovalues",
    path: "Film: from view to view",
    time: "Film: through time",
  },
  from: "From isovalue",
  to: "To isovalue",
  views: (n: number) => plural(n, { one: `${n} view`, other: `${n} views` }),
  addView: "Add this view",
  removeAll: "Remove all",
  size: "Size in pixels",
  asShown: "As shown",
  timesShown: (times: number) => `${times} × as shown`,
  otherSize: "Other …",
  width: "Width",
  height: "Height",
  seconds: "Seconds",
  framesPerSecond: "Frames per second",
  file: "File",
  webm: "WebM video",
  pngs: "PNG files in a ZIP",
  svg: "SVG: the picture, with lines and letters above it",
  marks: "Above the picture",
  markNames: {
    title: "Title",
    scale: "Scale bar",
    axes: "Axes",
    legend: "Legend",
    measurements: "Measurements",
  },
  transparent: "Without background (transparent)",
  frames: (n: number) => `${n} frames`,
  atMost: (frames: string, bytes: string) => `${frames}, at most about ${bytes}`,
  save: "Save",
  cancel: "Cancel",
  cancelled: "Cancelled",
  saving: "Saving",
  preparing: "Preparing",
  fetching: (bytes: string) => `Fetching: ${bytes} to go`,
  drawing: (percent: number) => `Drawing: ${percent} %`,
  saved: (bytes: string) => `Saved: ${bytes}.`,
  noPicture: "There is no picture yet",
  limited: "Parts are coarser than this size can show: the memory limit was reached.",
  notFetched: "Parts are coarser than this size can show: their data could not be fetched.",
  noVideo: (width: number, height: number) =>
    `this browser encodes no video of ${width} × ${height} pixels: choose a smaller size, or PNG files`,
  wrongSize: (most: number) => `Width and height: whole numbers from 1 to ${most}.`,
  wrongSeconds: (most: string, framesPerSecond: number) =>
    `Seconds: at most ${most} at ${framesPerSecond} frames per second.`,
  wrongIsovalues: "The isovalues from and to: numbers.",
  tooFewViews: "Add at least two views: close this, move the view, and come back.",
});
