import "./help.css";
import { html, render } from "lit";

const rows: [string, string][] = [
  ["Drag, one finger, arrow keys", "Rotate"],
  ["Right drag, Shift drag, two fingers, Shift + arrows", "Pan"],
  ["Wheel, pinch, + and −", "Zoom"],
  ["Double click", "Make this point of the surface the centre of rotation"],
  ["L + drag", "Move the key light"],
  [
    "Drag a handle of the clip box, arrow keys on it",
    "Move a face; the handles are shown while the section Clipping is open",
  ],
  ["[ and ]", "Lower or raise the isovalue; with Shift in small steps"],
  ["1 … 6", "Front, back, left, right, above, below"],
  ["V", "Show the whole volume, without turning"],
  ["P", "Perspective or orthographic"],
  [
    "M",
    "Measure distances: Enter takes the middle of the picture, Shift + Enter ends a path, Escape ends",
  ],
  ["R", "Reset the view"],
  ["Ctrl + Z, Ctrl + Shift + Z", "Take back, or repeat, the last change of the view"],
  ["C", "Copy a link to this view"],
  ["S, Shift + S", "Save a picture; one of any size, or a film"],
  ["F", "Show or hide the controls"],
  ["T", "Dark or light theme"],
  ["?", "This help"],
];

let dialog: (HTMLElement & { open: boolean }) | null = null;

export function showHelp(): void {
  if (!dialog) {
    const holder = document.createElement("div");
    document.body.append(holder);
    render(
      html`<wa-dialog label="Keys and gestures" light-dismiss class="help">
        <!-- With the focus, arrow keys scroll it. -->
        <table tabindex="0" aria-label="Keys and gestures">
          <tbody>
            ${rows.map(([keys, effect]) => html`<tr><th scope="row">${keys}</th><td>${effect}</td></tr>`)}
          </tbody>
        </table>
        <p class="quiet">
          The address of this page always holds the whole view: volume, isovalues, camera, colours.
        </p>
      </wa-dialog>`,
      holder,
    );
    dialog = holder.firstElementChild as typeof dialog;
  }
  if (dialog) dialog.open = true;
}
