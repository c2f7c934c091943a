import { pageTexts } from "../../texts/page.ts";
import { Viewer } from "../../viewer/viewer.ts";

/** The canvas of a volume page, and its viewer. */
export interface View {
  canvas: HTMLCanvasElement;
  viewer: Viewer;
}

interface PreparedView extends View {
  reset: () => void;
}

let prepared: PreparedView | undefined;

/** Loads the renderer and compiles its shaders in advance, for the next `takeView`. */
export function prepareView(): void {
  if (prepared) return;
  prepared = newView();
  prepared.viewer.prepare().catch(() => {}); // opening a volume retries this, and reports the error
}

/** Frees a prepared view that was not used. */
export function releaseView(): void {
  prepared?.viewer.dispose();
  prepared = undefined;
}

/** Returns the prepared view, or a new one. `reset`: the action of the key R. */
export function takeView(reset: () => void): View {
  const view = prepared ?? newView();
  prepared = undefined;
  view.reset = reset;
  return view;
}

function newView(): PreparedView {
  const canvas = viewCanvas();
  const viewer = new Viewer(canvas, { reset: () => view.reset() });
  const view = { canvas, viewer, reset: () => viewer.reset() };
  return view;
}

function viewCanvas(): HTMLCanvasElement {
  const canvas = document.createElement("canvas");
  canvas.className = "view";
  canvas.id = "view";
  canvas.tabIndex = 0;
  canvas.setAttribute("role", "application");
  canvas.setAttribute("aria-roledescription", pageTexts.view3d);
  return canvas;
}
