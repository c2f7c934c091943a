/** The actions of gestures on the camera. Pixels are CSS pixels. */
export interface CameraActions {
  orbit(rightDegrees: number, upDegrees: number): void;
  pan(rightPx: number, downPx: number): void;
  /** Multiplies the distance; `at`: the point under the pointer, from the canvas's centre. */
  zoom(factor: number, at?: { x: number; y: number }): void;
  /** Turns the key light. */
  turnLight(rightDegrees: number, upDegrees: number): void;
  reset(): void;
}

/** A drag across the canvas's height turns the view by this much. */
const degreesPerHeight = 180;
const keyDegrees = 5;
const keyPanPx = 40;
const keyZoom = 1.15;

interface Point {
  x: number;
  y: number;
}

/**
 * Mouse (left: orbit; right, middle or Shift: pan; L held: key light; wheel: zoom), touch (one finger: orbit; two:
 * pinch and pan), pen, and keys on the canvas (arrows: orbit; Shift and arrows: pan; + −: zoom; R:
 * reset). The returned function removes all listeners.
 */
export function attachControls(
  canvas: HTMLCanvasElement,
  actions: CameraActions,
  reset?: () => void,
): () => void {
  const pointers = new Map<number, Point>();
  let panning = false;
  let lighting = false;
  let isLightKeyDown = false;
  const listeners = new AbortController();
  const { signal } = listeners;
  canvas.style.touchAction = "none";

  const orbitBy = (dx: number, dy: number) => {
    const scale = degreesPerHeight / Math.max(canvas.clientHeight, 1);
    // The surface follows the pointer, so the eye moves in the opposite direction. y points down.
    actions.orbit(-dx * scale, dy * scale);
  };

  const lightBy = (dx: number, dy: number) => {
    const scale = degreesPerHeight / Math.max(canvas.clientHeight, 1);
    actions.turnLight(dx * scale, -dy * scale);
  };

  const fromCentre = (point: Point): Point => {
    const box = canvas.getBoundingClientRect();
    return { x: point.x - box.left - box.width / 2, y: point.y - box.top - box.height / 2 };
  };

  canvas.addEventListener(
    "pointerdown",
    (event) => {
      canvas.setPointerCapture(event.pointerId);
      pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
      lighting = isLightKeyDown;
      panning = event.button !== 0 || event.shiftKey || event.ctrlKey || event.metaKey;
    },
    { signal },
  );

  canvas.addEventListener(
    "pointermove",
    (event) => {
      const before = pointers.get(event.pointerId);
      if (!before) return;
      const after = { x: event.clientX, y: event.clientY };
      const dx = after.x - before.x;
      const dy = after.y - before.y;
      if (pointers.size === 1) {
        if (lighting) lightBy(dx, dy);
        else if (panning) actions.pan(dx, dy);
        else orbitBy(dx, dy);
      } else if (pointers.size === 2) {
        const other = [...pointers].find(([id]) => id !== event.pointerId)?.[1];
        if (other) {
          // The midpoint of two fingers moves by half of each finger's movement.
          actions.pan(dx / 2, dy / 2);
          const spreadBefore = Math.hypot(before.x - other.x, before.y - other.y);
          const spreadAfter = Math.hypot(after.x - other.x, after.y - other.y);
          if (spreadBefore > 0 && spreadAfter > 0) {
            const middle = { x: (after.x + other.x) / 2, y: (after.y + other.y) / 2 };
            actions.zoom(spreadBefore / spreadAfter, fromCentre(middle));
          }
        }
      }
      pointers.set(event.pointerId, after);
    },
    { signal },
  );

  const release = (event: PointerEvent) => {
    pointers.delete(event.pointerId);
    panning = false;
  };
  canvas.addEventListener("pointerup", release, { signal });
  canvas.addEventListener("pointercancel", release, { signal });
  canvas.addEventListener("lostpointercapture", release, { signal });
  canvas.addEventListener("contextmenu", (event) => event.preventDefault(), { signal });

  canvas.addEventListener(
    "wheel",
    (event) => {
      event.preventDefault();
      // A pinch on a touchpad arrives as a wheel with Ctrl, in smaller steps.
      const speed = event.ctrlKey ? 0.01 : 0.0015;
      const delta = Math.max(-240, Math.min(240, event.deltaY * pixelsPerUnit(event)));
      actions.zoom(Math.exp(delta * speed), fromCentre({ x: event.clientX, y: event.clientY }));
    },
    { signal, passive: false },
  );

  // The picture need not have the focus.
  const lightKey = (event: KeyboardEvent) => {
    if (event.key === "l" || event.key === "L") isLightKeyDown = event.type === "keydown";
  };
  window.addEventListener("keydown", lightKey, { signal });
  window.addEventListener("keyup", lightKey, { signal });
  window.addEventListener("blur", () => (isLightKeyDown = false), { signal });

  canvas.addEventListener(
    "keydown",
    (event) => {
      if (handleCameraKey(event, actions, reset)) event.preventDefault();
    },
    { signal },
  );

  return () => listeners.abort();
}

/**
 * Converts a wheel event to pixels. Firefox reports lines, three per notch (other browsers: about
 * 120 px), or pages if the system is configured for this.
 */
function pixelsPerUnit({ deltaMode }: WheelEvent): number {
  if (deltaMode === WheelEvent.DOM_DELTA_LINE) return 40;
  return deltaMode === WheelEvent.DOM_DELTA_PAGE ? 120 : 1;
}

/** Handles a key. Returns false if it has no action. `reset` replaces that of `actions`. */
export function handleCameraKey(
  event: KeyboardEvent,
  actions: CameraActions,
  reset = () => actions.reset(),
): boolean {
  if (event.ctrlKey || event.metaKey || event.altKey) return false;
  const arrows: Record<string, [number, number]> = {
    ArrowLeft: [-1, 0],
    ArrowRight: [1, 0],
    ArrowUp: [0, -1],
    ArrowDown: [0, 1],
  };
  const arrow = arrows[event.key];
  if (arrow) {
    const [right, down] = arrow;
    if (event.shiftKey) actions.pan(right * keyPanPx, down * keyPanPx);
    else actions.orbit(right * keyDegrees, -down * keyDegrees);
    return true;
  }
  if (event.key === "+" || event.key === "=") actions.zoom(1 / keyZoom);
  else if (event.key === "-" || event.key === "_") actions.zoom(keyZoom);
  else if (event.key === "r" || event.key === "R") reset();
  else return false;
  return true;
}
