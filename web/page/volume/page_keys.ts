import { axisViews } from "../../viewer/camera_views.ts";
import { type CameraActions, handleCameraKey } from "../../viewer/controls.ts";
import type { SurfaceSettings } from "../panel/surface_settings.ts";
import { toggleTheme } from "../shell/theme.ts";
import type { LoadedParts } from "./loaded_parts.ts";
import type { PageLayout } from "./page_layout.ts";
import type { LayoutActions } from "./volume_layout.ts";

/** Handles the keys of the page until the signal ends it. `restore`: undo or redo. */
export function listenToKeys(
  canvas: HTMLElement,
  camera: CameraActions,
  actions: Readonly<Record<string, () => void>>,
  restore: (step: "undo" | "redo") => void,
  signal: AbortSignal,
): void {
  const handle = (event: KeyboardEvent) => {
    const step = historyStep(event, canvas);
    if (step) {
      event.preventDefault();
      restore(step);
    }
    handlePageKey(event, canvas, camera, actions);
  };
  window.addEventListener("keydown", handle, { signal });
}

/**
 * Handles a key pressed anywhere on the page: moves the camera, or calls the entry of `actions` for
 * it (by KeyboardEvent.key), unless a control, a dialog or the browser uses the key.
 */
function handlePageKey(
  event: KeyboardEvent,
  canvas: HTMLElement,
  camera: CameraActions,
  actions: Readonly<Record<string, () => void>>,
): void {
  if (event.defaultPrevented || isOfBrowser(event)) return;
  if (document.querySelector("wa-dialog[open]")) return;
  const focus = focusOf(event, canvas);
  if (focus === "text") return;
  if (focus === "none" && handleCameraKey(event, camera, actions.r)) {
    event.preventDefault();
    return;
  }
  // Caps Lock does not change the meaning of a key.
  const action =
    actions[event.shiftKey ? event.key : event.key.toLowerCase()] ?? actions[event.key];
  if (action) {
    action();
    event.preventDefault();
  }
}

/**
 * Whether the browser or the system uses the key. Many keyboards have brackets only with Option, or with AltGr, which
 * is Control and Alt on Windows.
 */
function isOfBrowser({ key, ctrlKey, metaKey, altKey }: KeyboardEvent): boolean {
  if (metaKey) return true;
  return altKey ? !"[]{}".includes(key) : ctrlKey;
}

/** The action of a key for undo and redo, unless a text field uses the key. */
function historyStep(event: KeyboardEvent, canvas: HTMLElement): "undo" | "redo" | undefined {
  if (event.defaultPrevented || event.altKey || !(event.ctrlKey || event.metaKey)) return undefined;
  if (document.querySelector("wa-dialog[open]") || focusOf(event, canvas) === "text") {
    return undefined;
  }
  const key = event.key.toLowerCase();
  if (key === "y") return "redo";
  if (key !== "z") return undefined;
  return event.shiftKey ? "redo" : "undo";
}

/**
 * The kind of element that uses the key: text fields use all keys, other controls some, the page
 * the rest.
 */
function focusOf(event: KeyboardEvent, canvas: HTMLElement): "text" | "control" | "none" {
  const origin = event.composedPath()[0];
  if (!(origin instanceof HTMLElement) || origin === document.body || origin === canvas)
    return "none";
  const isField = origin.matches("input, textarea, select, [role=combobox], [role=listbox]");
  const takesText = isField && !origin.matches("[type=color], [type=range]");
  if (takesText || origin.isContentEditable) return "text";
  return "control";
}

/** The actions of keys that do not move the camera, as `shell/help.ts` lists them. */
export function keyActions(
  surfaces: SurfaceSettings,
  parts: LoadedParts,
  layout: PageLayout,
  actions: LayoutActions,
): Readonly<Record<string, () => void>> {
  return {
    "[": () => surfaces.step(-1, "hundredth"),
    "]": () => surfaces.step(1, "hundredth"),
    "{": () => surfaces.step(-1, "step"),
    "}": () => surfaces.step(1, "step"),
    "?": actions.help,
    ",": () => parts.time.step(-1),
    ".": () => parts.time.step(1),
    k: () => parts.time.togglePlay(),
    c: actions.copyLink,
    s: actions.savePicture,
    S: actions.openCapture,
    t: toggleTheme,
    f: () => layout.togglePanel(),
    r: actions.reset,
    v: actions.fit,
    p: actions.toggleProjection,
    i: () => parts.nameMiddle(),
    m: () => void parts.beginMeasuring(),
    ...Object.fromEntries(axisViews.map((view, i) => [i + 1, () => actions.lookAlong(view)])),
    Escape: () => {
      parts.measure?.tool.choose(null);
      layout.openSheet(false);
    },
  };
}
