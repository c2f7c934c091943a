import type { ClipHandles } from "../overlay/clip_handles.ts";
import type { Overlay } from "../overlay/overlay.ts";
import { type OverlayPart, overlayParts } from "../overlay/parts.ts";
import type { OverlayTexts } from "../texts/overlay.ts";
import { CameraMotion } from "../viewer/camera_motion.ts";
import { type AxisView, cameraAlong } from "../viewer/camera_views.ts";
import type { Clip } from "../viewer/types.ts";
import type { Viewer } from "../viewer/viewer.ts";

/** The overlays that an element can show above its picture. */
export const shownParts = [...overlayParts, "clip"] as const;
export type ShownPart = (typeof shownParts)[number];

/** "axes,scale" → its parts; undefined if one is not known. */
export function readParts(text: string | null): ReadonlySet<ShownPart> | undefined {
  const names = (text ?? "").split(",").map((name) => name.trim());
  const parts = names
    .filter((name) => name !== "")
    .map((name) => shownParts.find((p) => p === name));
  return parts.every((part) => part !== undefined) ? new Set(parts) : undefined;
}

/**
 * The overlay and the clip handles of an element. They are loaded at their first use, and exist
 * while the element has a viewer.
 */
export class OverlayArea {
  readonly element = document.createElement("div");
  readonly #changeClip: (clip: Clip) => void;
  readonly #failed: (error: unknown) => void;
  #parts: ReadonlySet<ShownPart> = new Set();
  #texts: OverlayTexts | undefined;
  #viewer: Viewer | null = null;
  #motion: CameraMotion | null = null;
  #overlay: Overlay | null = null;
  #handles: ClipHandles | null = null;

  /** changeClip: a face of the clip box was dragged. failed: the code could not be loaded. */
  constructor(changeClip: (clip: Clip) => void, failed: (error: unknown) => void) {
    this.element.className = "overlays";
    this.#changeClip = changeClip;
    this.#failed = failed;
  }

  show(parts: ReadonlySet<ShownPart>): void {
    this.#parts = parts;
    void this.#update();
  }

  /** undefined: the English texts. */
  translate(texts: OverlayTexts | undefined): void {
    this.#texts = texts;
    this.attach(this.#viewer);
  }

  /**
   * Follows another viewer, or none. Without a viewer, the overlays stay as they are, like the last
   * picture.
   */
  attach(viewer: Viewer | null): void {
    this.#motion?.stop();
    this.#overlay?.stop();
    this.#handles?.stop();
    this.element.inert = viewer === null;
    this.#overlay = null;
    this.#handles = null;
    this.#viewer = viewer;
    this.#motion = viewer && new CameraMotion(viewer);
    void this.#update();
  }

  clear(): void {
    this.attach(null);
    this.element.replaceChildren();
  }

  /** The clipping has changed. */
  clipChanged(): void {
    this.#handles?.request();
  }

  async #update(): Promise<void> {
    const viewer = this.#viewer;
    if (!viewer) return;
    const has = (part: OverlayPart) => this.#parts.has(part);
    try {
      if (overlayParts.some(has)) await this.#loadOverlay(viewer);
      if (this.#parts.has("clip")) await this.#loadHandles(viewer);
    } catch (error) {
      this.#failed(error);
      return;
    }
    if (viewer !== this.#viewer) return;
    this.#overlay?.show(new Set(overlayParts.filter(has)));
    if (!this.#parts.has("clip")) {
      this.#handles?.stop();
      this.#handles = null;
    }
  }

  async #loadOverlay(viewer: Viewer): Promise<void> {
    if (this.#overlay) return;
    const { Overlay } = await import("../overlay/overlay.ts");
    if (this.#overlay || viewer !== this.#viewer) return;
    const look = (view: AxisView) => {
      if (viewer.camera) this.#motion?.to(cameraAlong(viewer.camera, view));
    };
    this.#overlay = new Overlay(viewer, look, this.#texts);
    // Replaces the element that a previous viewer left.
    this.element.replaceChildren(this.#overlay.element);
    if (this.#handles) this.element.append(this.#handles.element);
  }

  async #loadHandles(viewer: Viewer): Promise<void> {
    if (this.#handles) return;
    const { ClipHandles } = await import("../overlay/clip_handles.ts");
    if (this.#handles || viewer !== this.#viewer || !this.#parts.has("clip")) return;
    this.#handles = new ClipHandles(viewer, this.#changeClip, this.#texts);
    this.element.append(this.#handles.element);
    this.#handles.request();
  }
}
