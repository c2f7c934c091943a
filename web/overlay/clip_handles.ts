import type { StoreInfo } from "../core/types.ts";
import { localized } from "../texts/numbers.ts";
import { type OverlayTexts, overlayTexts } from "../texts/overlay.ts";
import type { Clip } from "../viewer/types.ts";
import type { Viewer } from "../viewer/viewer.ts";
import {
  type ClipFace,
  clipEdges,
  clipFaces,
  draggedShare,
  faceOnScreen,
  movedFace,
  shareAfterKey,
  shareOf,
} from "./clip_faces.ts";
import { LayerDrawing } from "./layer_drawing.ts";
import { type Screen, screenOf } from "./screen.ts";
import { layerElement, setAttributes, svgElement } from "./shapes.ts";
import { clipStyles } from "./styles.ts";

/** A drag in progress, in the coordinates of the pointer. */
interface Drag {
  face: ClipFace;
  pointer: number;
  x: number;
  y: number;
  /** The clip at the time when the face was grabbed. */
  clip: Clip;
}

interface Handle {
  face: ClipFace;
  element: HTMLElement;
  value: HTMLElement;
}

const axes = ["x", "y", "z"] as const;
/** The least distance from the middle of a handle to the picture's edge. */
const edgePx = 16;
/** The value beside a handle needs this width. */
const valuePx = 100;

/**
 * Draws the clip box over the picture of a viewer, with a handle in the middle of each face. Pointers
 * drag a handle along its axis, and keys move it. The element must cover exactly the canvas.
 */
export class ClipHandles {
  readonly element: HTMLElement;
  readonly #viewer: Viewer;
  readonly #change: (clip: Clip) => void;
  readonly #edges = svgElement("svg", { class: "clip-edges", "aria-hidden": "true" });
  readonly #handles: readonly Handle[];
  readonly #drawing: LayerDrawing;
  #drag: Drag | null = null;

  /** change: called with the new clip, which the caller must set. */
  constructor(viewer: Viewer, change: (clip: Clip) => void, texts: OverlayTexts = overlayTexts) {
    this.#viewer = viewer;
    this.#change = change;
    const { element, root } = layerElement(clipStyles);
    this.element = element;
    const group = document.createElement("div");
    setAttributes(group, { role: "group", "aria-label": texts.clipFaces });
    this.#handles = clipFaces.map((face) => this.#newHandle(face, texts));
    group.append(...this.#handles.map((handle) => handle.element));
    root.append(this.#edges, group);
    this.#drawing = new LayerDrawing(viewer, this.element, () => this.#draw());
  }

  stop(): void {
    this.#drawing.stop();
    this.element.remove();
  }

  /** Draws in the next frame: call it when the clip has changed. */
  request(): void {
    this.#drawing.request();
  }

  #draw(): void {
    const { info, clip } = this.#viewer;
    const screen = screenOf(this.#viewer, this.element);
    this.element.style.visibility = info && screen ? "" : "hidden";
    if (!info || !screen) return;
    const lines = clipEdges(info, screen, clip).map(({ from, to }) =>
      svgElement("line", { x1: from.x, y1: from.y, x2: to.x, y2: to.y }),
    );
    this.#edges.replaceChildren(...lines);
    for (const handle of this.#handles) this.#drawHandle(handle, info, screen, clip);
  }

  #newHandle(face: ClipFace, texts: OverlayTexts): Handle {
    const axis = axes[face.axis];
    const element = document.createElement("div");
    const value = document.createElement("span");
    value.className = "clip-value";
    setAttributes(value, { "aria-hidden": "true" });
    setAttributes(element, {
      role: "slider",
      tabindex: 0,
      "aria-label": face.end === "low" ? texts.lowerFace(axis) : texts.upperFace(axis),
      "aria-valuemin": 0,
      "aria-valuemax": 100,
    });
    element.append(value);
    element.addEventListener("pointerdown", (event) => this.#grab(event, face));
    element.addEventListener("pointermove", (event) => this.#move(event));
    element.addEventListener("pointerup", (event) => this.#release(event));
    element.addEventListener("pointercancel", (event) => this.#release(event));
    element.addEventListener("keydown", (event) => this.#key(event, face));
    element.addEventListener("wheel", (event) => this.#wheel(event));
    return { face, element, value };
  }

  /**
   * If the middle of a face is outside the picture, its handle is at the picture's edge, so that it
   * keeps the focus and can be dragged back.
   */
  #drawHandle({ face, element, value }: Handle, info: StoreInfo, screen: Screen, clip: Clip): void {
    const at = faceOnScreen(info, screen, clip, face);
    const inside = (n: number, size: number) =>
      Math.max(edgePx, Math.min(size - edgePx, n)).toFixed(2);
    const percent = Math.round(1000 * shareOf(clip, face)) / 10;
    const text = localized(`${axes[face.axis]} ${percent} %`);
    element.style.visibility = at ? "" : "hidden";
    if (at) {
      element.style.transform = `translate(${inside(at.x, screen.width)}px,${inside(at.y, screen.height)}px)`;
      element.style.zIndex = at.isBehind ? "0" : "1";
    }
    const classes = [
      "clip-handle",
      ...(at?.isBehind ? ["behind"] : []),
      ...(this.#drag?.face === face ? ["dragged"] : []),
      ...(at && at.x > screen.width - valuePx ? ["at-right"] : []),
    ];
    setAttributes(element, {
      class: classes.join(" "),
      "aria-valuenow": percent,
      "aria-valuetext": text,
    });
    value.textContent = text;
  }

  #grab(event: PointerEvent, face: ClipFace): void {
    // If a handle is removed during a drag, the end of the drag is not reported. This must not prevent
    // other drags.
    if (!event.isPrimary || event.button !== 0) return;
    (event.currentTarget as HTMLElement).setPointerCapture(event.pointerId);
    const { pointerId: pointer, clientX: x, clientY: y } = event;
    this.#drag = { face, pointer, x, y, clip: this.#viewer.clip };
    this.request();
  }

  #move(event: PointerEvent): void {
    const drag = this.#drag;
    const { info } = this.#viewer;
    const screen = screenOf(this.#viewer, this.element);
    if (drag?.pointer !== event.pointerId || !info || !screen) return;
    const moved = { right: event.clientX - drag.x, down: event.clientY - drag.y };
    this.#set(drag.face, draggedShare(info, screen, drag.clip, drag.face, moved));
  }

  #release(event: PointerEvent): void {
    if (this.#drag?.pointer !== event.pointerId) return;
    this.#drag = null;
    this.request();
  }

  #key(event: KeyboardEvent, face: ClipFace): void {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const share = shareAfterKey(event.key, shareOf(this.#viewer.clip, face), event.shiftKey);
    if (share === undefined) return;
    event.preventDefault();
    this.#set(face, share);
  }

  /** The wheel also zooms while the pointer is over a handle. */
  #wheel(event: WheelEvent): void {
    event.preventDefault();
    this.#viewer.canvas.dispatchEvent(new WheelEvent("wheel", event));
  }

  #set(face: ClipFace, share: number): void {
    const { clip } = this.#viewer;
    const moved = movedFace(clip, face, share);
    if (shareOf(moved, face) !== shareOf(clip, face)) this.#change(moved);
  }
}
