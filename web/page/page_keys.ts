import { type CameraActions, handleCameraKey } from "../viewer/index.ts";

/**
 * A key that was pressed anywhere on the page: moves the camera, or does what `actions` has for it
 * (by KeyboardEvent.key), unless a control, a dialog or the browser wants it.
 */
export function handlePageKey(
  event: KeyboardEvent,
  canvas: HTMLElement,
  camera: CameraActions,
  actions: Readonly<Record<string, () => void>>,
): void {
  if (event.defaultPrevented || event.ctrlKey || event.metaKey || event.altKey) return;
  if (document.querySelector("wa-dialog[open]")) return;
  const focus = focusOf(event, canvas);
  if (focus === "text") return;
  if (focus === "none" && handleCameraKey(event, camera)) {
    event.preventDefault();
    return;
  }
  // Caps Lock does not make another key of it.
  const action =
    actions[event.shiftKey ? event.key : event.key.toLowerCase()] ?? actions[event.key];
  if (action) {
    action();
    event.preventDefault();
  }
}

/** What a key would go to: text fields take all keys, other controls some, the page the rest. */
function focusOf(event: KeyboardEvent, canvas: HTMLElement): "text" | "control" | "none" {
  const origin = event.composedPath()[0];
  if (!(origin instanceof HTMLElement) || origin === document.body || origin === canvas)
    return "none";
  const isField = origin.matches("input, textarea, select, [role=combobox], [role=listbox]");
  if ((isField && !origin.matches("[type=color]")) || origin.isContentEditable) return "text";
  return "control";
}
