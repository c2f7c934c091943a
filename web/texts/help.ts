import { part } from "./part.ts";

/** The dialog of keys and gestures. */
export const helpTexts = part("help", {
  title: "Keys and gestures",
  rows: [
    ["Drag, one finger, arrow keys", "Rotate"],
    ["Right drag, Shift drag, two fingers, Shift + arrows", "Pan"],
    ["Wheel, pinch, + and −", "Zoom"],
    ["Double click", "Make this point of the surface the centre of rotation"],
    ["Click, I", "Name the layer, with the volume of its label; I: in the middle of the picture"],
    ["L + drag", "Move the key light"],
    [
      "Drag a handle of the clip box, arrow keys on it",
      "Move a face; the handles are shown while the section Clipping is open",
    ],
    ["[ and ]", "Lower or raise the isovalue; with Shift in small steps"],
    [", and .", "One step back or forward in time"],
    ["K", "Play or pause a scene that changes with time"],
    ["1 … 6", "Front, back, left, right, above, below"],
    ["V", "Show the whole volume, without turning"],
    ["P", "Perspective or orthographic"],
    [
      "M",
      "Measure distances: Enter takes the middle of the picture, Shift + Enter ends a path, Escape ends",
    ],
    ["R", "Reset the view"],
    ["Ctrl + Z, Ctrl + Shift + Z", "Undo or redo the last change of the view"],
    [
      "Arrow keys, Alt + arrows, F2, Delete in the list of layers",
      "Go to another layer, move it in the list, rename it, remove it",
    ],
    ["C", "Copy a link to this view"],
    ["S, Shift + S", "Save a picture; one of any size, or a film"],
    ["F", "Show or hide the controls"],
    ["T", "Dark or light theme"],
    ["?", "This help"],
  ] satisfies [string, string][],
  address:
    "The address of this page always holds the whole view: volume, isovalues, camera, colours.",
});
