import { listenToClicks } from "../viewer/clicks.ts";
import type { Label, SurfacePoint } from "../viewer/types.ts";
import type { Viewer } from "../viewer/viewer.ts";

/** The point of a surface that was clicked, with its layer: the detail of the event `pick`. */
export interface PickedSurface extends SurfacePoint {
  /** The name of the layer; empty if it has none. */
  name: string;
  /** The label that the layer shows, with its volume in the world of the picture. Null: none. */
  label: Label | null;
}

/**
 * Reports the event `pick` for clicks and taps on surfaces, and for Enter, which picks in the middle of the
 * picture. `viewer`: null while the element has no WebGL context.
 */
export function listenToPicks(element: HTMLElement, viewer: () => Viewer | null): void {
  const pick = (event: Event, position: (canvas: HTMLCanvasElement) => [number, number]) => {
    const present = viewer();
    // Controls and captions are parts of the element as well.
    if (!present || event.composedPath()[0] !== present.canvas) return;
    const point = present.pick(...position(present.canvas));
    const layer = present.layers.find(({ id }) => id === point?.layer);
    if (!point || !layer) return;
    const { title = "", name = "" } = layer.info?.metadata ?? {};
    const detail: PickedSurface = {
      ...point,
      name: layer.name || title || name,
      label: layer.placedLabel,
    };
    element.dispatchEvent(new CustomEvent("pick", { detail }));
  };
  listenToClicks(element, (event) =>
    pick(event, (canvas) => {
      const { left, top } = canvas.getBoundingClientRect();
      return [event.clientX - left, event.clientY - top];
    }),
  );
  element.addEventListener("keydown", (event) => {
    const isPlain = !(event.ctrlKey || event.metaKey || event.altKey || event.shiftKey);
    if (event.key !== "Enter" || !isPlain || event.defaultPrevented) return;
    pick(event, ({ clientWidth, clientHeight }) => [clientWidth / 2, clientHeight / 2]);
  });
}
