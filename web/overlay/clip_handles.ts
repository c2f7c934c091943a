import { html, nothing, render, svg, type TemplateResult } from "lit";
import { classMap } from "lit/directives/class-map.js";
import type { StoreInfo } from "../stream/index.ts";
import type { Clip, Viewer } from "../viewer/index.ts";
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
import { Screen } from "./screen.ts";

/** A drag in progress, in the coordinates of the pointer. */
interface Drag {
  face: ClipFace;
  pointer: number;
  x: number;
  y: number;
  /** Of the time when the face was grabbed. */
  clip: Clip;
}

const axes = ["x", "y", "z"] as const;
/** From the middle of a handle to the picture's edge, at least. */
const edgePx = 16;
/** The value beside a handle needs this width. */
const valuePx = 100;

/**
 * The clip box above the picture of a viewer, with a handle in the middle of each face: pointers drag
 * it along its axis, and keys move it. The element is to lie exactly on the canvas.
 */
export class ClipHandles {
  readonly element = document.createElement("div");
  readonly #viewer: Viewer;
  readonly #change: (clip: Clip) => void;
  readonly #cleanup: (() => void)[];
  #drag: Drag | null = null;
  #handle = 0;

  /** change: called with another clip, which the caller is to set. */
  constructor(viewer: Viewer, change: (clip: Clip) => void) {
    this.#viewer = viewer;
    this.#change = change;
    this.element.className = "overlay";
    const size = new ResizeObserver(() => this.request());
    size.observe(this.element);
    this.#cleanup = [
      viewer.on("camera", () => this.request()),
      viewer.on("opened", () => this.request()),
      () => size.disconnect(),
    ];
  }

  stop(): void {
    cancelAnimationFrame(this.#handle);
    for (const clean of this.#cleanup) clean();
    this.element.remove();
  }

  /** Draws in the next frame: call it when the clip has changed. */
  request(): void {
    if (this.#handle !== 0) return;
    this.#handle = requestAnimationFrame(() => {
      this.#handle = 0;
      this.#draw();
    });
  }

  get #screen(): Screen | undefined {
    const { clientWidth: width, clientHeight: height } = this.element;
    const matrix = this.#viewer.viewProjection(width, height);
    return matrix && width > 0 && height > 0 ? new Screen(matrix, width, height) : undefined;
  }

  #draw(): void {
    const { info, clip } = this.#viewer;
    const screen = this.#screen;
    if (!info || !screen) {
      render(nothing, this.element);
      return;
    }
    render(
      html`<svg class="clip-edges" aria-hidden="true">
          ${clipEdges(info, screen, clip).map(
            ({ from, to }) => svg`<line x1=${from.x} y1=${from.y} x2=${to.x} y2=${to.y} />`,
          )}
        </svg>
        <div role="group" aria-label="Faces of the clip box">
          ${clipFaces.map((face) => this.#handleOf(face, info, screen, clip))}
        </div>`,
      this.element,
    );
  }

  /**
   * A face whose middle is outside of the picture has its handle at the picture's edge, so that the
   * handle keeps the focus and can be dragged back.
   */
  #handleOf(face: ClipFace, info: StoreInfo, screen: Screen, clip: Clip): TemplateResult {
    const at = faceOnScreen(info, screen, clip, face);
    const inside = (n: number, size: number) =>
      Math.max(edgePx, Math.min(size - edgePx, n)).toFixed(2);
    const value = Math.round(1000 * shareOf(clip, face)) / 10;
    const axis = axes[face.axis];
    const place = at
      ? `transform:translate(${inside(at.x, screen.width)}px,${inside(at.y, screen.height)}px);z-index:${at.isBehind ? 0 : 1}`
      : "visibility:hidden";
    const classes = {
      "clip-handle": true,
      behind: at?.isBehind ?? false,
      dragged: this.#drag?.face === face,
      "at-right": at !== undefined && at.x > screen.width - valuePx,
    };
    return html`<div
      class=${classMap(classes)}
      style=${place}
      role="slider"
      tabindex="0"
      aria-label=${`${face.end === "low" ? "Lower" : "Upper"} ${axis} face of the clip box`}
      aria-valuemin="0"
      aria-valuemax="100"
      aria-valuenow=${value}
      aria-valuetext=${`${axis} ${value} %`}
      @pointerdown=${(event: PointerEvent) => this.#grab(event, face)}
      @pointermove=${(event: PointerEvent) => this.#move(event)}
      @pointerup=${(event: PointerEvent) => this.#release(event)}
      @pointercancel=${(event: PointerEvent) => this.#release(event)}
      @keydown=${(event: KeyboardEvent) => this.#key(event, face)}
      @wheel=${(event: WheelEvent) => this.#wheel(event)}
    >
      <span class="clip-value" aria-hidden="true">${axis} ${value} %</span>
    </div>`;
  }

  #grab(event: PointerEvent, face: ClipFace): void {
    // A drag whose end was not seen, since its handle was removed, does not prevent others.
    if (!event.isPrimary || event.button !== 0) return;
    (event.currentTarget as HTMLElement).setPointerCapture(event.pointerId);
    const { pointerId: pointer, clientX: x, clientY: y } = event;
    this.#drag = { face, pointer, x, y, clip: this.#viewer.clip };
    this.request();
  }

  #move(event: PointerEvent): void {
    const drag = this.#drag;
    const { info } = this.#viewer;
    const screen = this.#screen;
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

  /** A handle is no hole in the picture: the wheel zooms above it as well. */
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
