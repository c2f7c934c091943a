import type { StoreInfo } from "../core/types.ts";
import type { SavedSurface, SaveSurfaceOptions } from "../mesh/save_surface.ts";
import type { Source } from "../stream/source.ts";
import { type Progress, StreamError } from "../stream/types.ts";
import { RendererError } from "../viewer/renderer_error.ts";
import { readColour } from "../viewer/setting_text.ts";
import type { Camera, Clip, Look, Projection, Slices, Surface } from "../viewer/types.ts";
import type { Viewer } from "../viewer/viewer.ts";
import { cameraOf, expected, projectionOf, surfacesOf } from "./element_attributes.ts";
import { ElementParts } from "./element_parts.ts";
import { sourceOf } from "./element_source.ts";
import { ElementView } from "./element_view.ts";
import { ElementViewer } from "./element_viewer.ts";
import { EventElement } from "./event_element.ts";
import { readParts, shownParts } from "./overlay_area.ts";
import { sharedSheet } from "./page_resources.ts";

/** Properties that may have been set before the element was defined. */
const ownProperties =
  "src source isovalues surfaces camera projection clip slices look controls show link".split(" ");

/**
 * Shows isosurfaces of a volume.
 *
 *     <isosplat-viewer src="head.isosplat" isovalue="60.5" controls></isosplat-viewer>
 *
 * Several elements of a page share their workers, their memory, and at most four WebGL contexts: an
 * element without one shows its last picture until it is seen or used again.
 *
 * @attr {string} src - The address of a store (any host that answers Range requests), or of a volume of a server: `https://host/v1/volumes/head`.
 * @attr {string} isovalue - One or more isovalues, with commas. Default: the volume's first suggestion. The element does not change it.
 * @attr {string} colour - The colours of the surfaces: `d9ccb3,c8553d`.
 * @attr {string} opacity - The opacities of the surfaces, 0 to 1: `0.4,1`.
 * @attr {string} camera - The first camera: `azimuth,elevation,distance,x,y,z[,roll[,field of view]]`, as in the address of the page. Default: the whole volume.
 * @attr {string} projection - `perspective` (the default) or `orthographic`.
 * @attr {string} background - The colour behind the surfaces, `rrggbb`. Default: white.
 * @attr {boolean} controls - Shows a slider and a field for the isovalue, and buttons.
 * @attr {string} show - The overlays above the picture, some of `axes,scale,box,clip`: orientation axes, a scale bar, the volume's box with ticks in mm, the clip box with handles. Default: nothing.
 * @attr {string} lang - The language of the element: `en` or `de`. Default: that of the nearest enclosing element with this attribute, when the element is added to the page. Messages of faults are in English.
 * @attr {string} link - The name of a group. Elements of a group have the same camera, isovalues, clipping and slices.
 *
 * @fires {CustomEvent<StoreInfo>} opened - A volume is open. Its first surface follows.
 * @fires {CustomEvent<Progress>} progress - The streaming progress has changed.
 * @fires {CustomEvent<Progress>} complete - Everything visible is drawn at the level that the view resolves.
 * @fires {CustomEvent<Camera>} camerachange - The camera has moved: by a gesture, by a call, or by the group.
 * @fires {CustomEvent<readonly number[]>} isovaluechange - The isovalues have changed: by the controls, by a call, or by the group.
 * @fires {CustomEvent<Clip>} clipchange - The clipping has changed: by a call, or by the group.
 * @fires {CustomEvent<Slices>} sliceschange - The slices have changed: by a call, or by the group.
 * @fires {CustomEvent<StreamError | RendererError>} fault - Something failed. `detail.message` states the expected value, the found value, and the remedy; the element retries where this can help.
 *
 * @slot - Shown above the picture, such as a caption.
 * @slot poster - Shown until the first surface.
 *
 * @csspart canvas - The picture.
 * @csspart message - The message of a fault.
 * @csspart controls - The bar of controls.
 * @csspart slider - The slider of the isovalue.
 * @csspart field - The field of the isovalue.
 * @csspart units - The units of the isovalue.
 * @csspart button - Each of the buttons.
 *
 * @cssprop --isosplat-text - The colour of text.
 * @cssprop --isosplat-panel - The background of controls and messages.
 * @cssprop --isosplat-accent - The colour of the slider and of the focus.
 */
export class IsosplatViewerElement extends EventElement {
  static readonly observedAttributes = [
    "src",
    "isovalue",
    "colour",
    "opacity",
    "camera",
    "projection",
    "background",
    "controls",
    "show",
    "link",
    "lang",
  ];

  readonly #root = this.attachShadow({ mode: "open" });
  readonly #parts = new ElementParts(this, this.#root, {
    setIsovalue: (isovalue) => this.#view.moveFirst(isovalue),
    changeClip: (clip) => {
      this.clip = clip;
    },
    reset: () => this.reset(),
    overlaysFailed: (error) => {
      const text = `what show="${this.show}" names could not be loaded: ${String(error)}`;
      this.#viewer.fault(new StreamError("unreachable", text, error));
    },
  });
  readonly #view = new ElementView(this, {
    viewer: () => this.viewer,
    info: () => this.info,
    isOpening: () => this.#viewer.isOpening,
    wake: () => this.#viewer.wake(),
    surfacesChanged: () => this.#parts.controls.show(this.isovalues[0]),
    clipChanged: () => this.#parts.overlays.clipChanged(),
  });
  readonly #viewer = new ElementViewer(this, this.#root, this.#parts, this.#view);

  constructor() {
    super();
    this.#root.adoptedStyleSheets = [sharedSheet()];
    // An element without a context gets one before a gesture on it begins.
    const wake = () => this.#viewer.wake(true);
    this.addEventListener("pointerenter", wake);
    this.addEventListener("pointerdown", wake);
    this.addEventListener("focusin", wake);
  }

  connectedCallback(): void {
    for (const name of ownProperties) this.#takeProperty(name);
    this.#parts.picture.setFocusable(true);
    void this.#parts.translate();
    this.#viewer.attach();
    this.#view.setAttached(true);
  }

  disconnectedCallback(): void {
    this.#view.setAttached(false);
    this.#viewer.detach();
  }

  attributeChangedCallback(name: string, before: string | null, now: string | null): void {
    if (before === now) return;
    if (name === "src") this.#viewer.setSource(now === null ? null : this.#sourceOf(now));
    else if (name === "camera") this.#readCamera(now);
    else if (name === "projection") this.#view.readProjection();
    else if (name === "background") this.look = { background: readColour(now) ?? "#ffffff" };
    else if (name === "controls") this.#parts.controls.element.hidden = now === null;
    else if (name === "show") this.#readShow(now);
    else if (name === "link") this.#view.relink(before);
    else if (name === "lang") void this.#parts.translate();
    else if (name === "isovalue") this.#view.readIsovalues();
    else this.surfaces = surfacesOf(this, this.isovalues);
  }

  /** The address of the volume: the attribute. */
  get src(): string {
    return this.getAttribute("src") ?? "";
  }
  set src(value: string | null | undefined) {
    if (typeof value === "string") this.setAttribute("src", value);
    else this.removeAttribute("src");
  }

  /** The source of the bytes. Set it instead of `src` for requests with tokens and headers. */
  get source(): Source | null {
    return this.#viewer.source;
  }
  set source(source: Source | null | undefined) {
    this.#viewer.setSource(source ?? null);
  }

  /** Shows the controls: the attribute. */
  get controls(): boolean {
    return this.hasAttribute("controls");
  }
  set controls(value: boolean) {
    this.toggleAttribute("controls", value);
  }

  /** The overlays above the picture: the attribute. */
  get show(): string {
    return this.getAttribute("show") ?? "";
  }
  set show(value: string | null | undefined) {
    if (value) this.setAttribute("show", value);
    else this.removeAttribute("show");
  }

  /** The name of the group: the attribute. */
  get link(): string {
    return this.getAttribute("link") ?? "";
  }
  set link(value: string) {
    if (value) this.setAttribute("link", value);
    else this.removeAttribute("link");
  }

  /**
   * The isovalues. New ones keep the colours of the existing surfaces. Null or undefined: those of
   * the attribute, else the volume's first suggestion.
   */
  get isovalues(): readonly number[] {
    return this.#view.isovalues;
  }
  set isovalues(asked: readonly number[] | null | undefined) {
    this.#view.isovalues = asked;
  }

  /** The isosurfaces with their colours and opacities. Null or undefined: those of the attributes. */
  get surfaces(): readonly Surface[] {
    return this.#view.surfaces;
  }
  set surfaces(asked: readonly Surface[] | null | undefined) {
    this.#view.surfaces = asked;
  }

  /** Null until a volume is open, or a camera is set. */
  get camera(): Camera | null {
    return this.#view.camera;
  }
  set camera(asked: Camera | null | undefined) {
    this.#view.camera = asked;
  }

  /** Perspective or orthographic: the attribute. */
  get projection(): Projection {
    return projectionOf(this);
  }
  set projection(projection: Projection) {
    this.setAttribute("projection", projection);
  }

  /** The part of the volume that is shown. Null or undefined: the whole volume. */
  get clip(): Clip {
    return this.#view.clip;
  }
  set clip(asked: Clip | null | undefined) {
    this.#view.clip = asked;
  }

  /**
   * Planes that show the volume's values where cells are loaded, and are hatched elsewhere. `along`
   * has the positions across x, y and z, as fractions of the volume or null; `plane` is an oblique
   * plane; `range` has the values shown as black and white. Null or undefined: none.
   */
  get slices(): Slices {
    return this.#view.slices;
  }
  set slices(asked: Slices | null | undefined) {
    this.#view.slices = asked;
  }

  /**
   * Splats, colouring, background and light. A new value changes only the settings that it
   * contains.
   */
  get look(): Partial<Look> {
    return this.#view.look;
  }
  set look(change: Partial<Look> | null | undefined) {
    this.#view.look = change;
  }

  /** The open volume; null before the first. */
  get info(): StoreInfo | null {
    return this.#viewer.info;
  }

  /** The last progress; null before the first. */
  get progress(): Progress | null {
    return this.#viewer.progress;
  }

  /** The viewer on the canvas; null while the element has no WebGL context. */
  get viewer(): Viewer | null {
    return this.#viewer.viewer;
  }

  /** Returns to the first view of the volume. */
  reset(): void {
    this.#viewer.wake(true);
    this.viewer?.reset();
  }

  /** Retries at once everything that waits for its next attempt. */
  retry(): void {
    this.#viewer.retry();
  }

  /** The picture as a PNG, at the resolution of the canvas. Rejects if there is none. */
  async screenshot(): Promise<Blob> {
    if (!this.viewer) throw new RendererError("nothing is drawn: the element is out of sight");
    return this.viewer.screenshot();
  }

  /**
   * The first surface as a file of triangles, at full detail unless `options` state otherwise: see
   * `saveSurface` of `isosplat/mesh`. Rejects if no volume is open.
   */
  async saveSurface(options: SaveSurfaceOptions = {}): Promise<SavedSurface> {
    const isovalue = this.isovalues[0];
    const access = this.viewer?.storeAccess;
    const { source } = this;
    if (isovalue === undefined || !source) throw new Error("no volume is open");
    const { SurfaceReader, saveSurface } = await import("../mesh/index.ts");
    return saveSurface(access ? new SurfaceReader(access) : source, isovalue, options);
  }

  /** A property that was set before the element was defined is an own property. Sets it again. */
  #takeProperty(name: string): void {
    if (!Object.hasOwn(this, name)) return;
    const element = this as unknown as Record<string, unknown>;
    const value = element[name];
    delete element[name];
    element[name] = value;
  }

  #readCamera(text: string | null): void {
    const camera = cameraOf(this);
    if (camera) this.camera = camera;
    else if (text) this.#viewer.fault(expected("camera", text, "azimuth,elevation,distance,x,y,z"));
  }

  #readShow(text: string | null): void {
    const parts = readParts(text);
    this.#parts.overlays.show(parts ?? new Set());
    const names = `some of ${shownParts.join(",")}`;
    if (!parts) this.#viewer.fault(expected("show", text ?? "", names));
  }

  #sourceOf(src: string): Source | null {
    const source = sourceOf(src, document.baseURI);
    const what = "the http or https address of a store";
    if (!source) this.#viewer.fault(expected("src", src, what));
    return source ?? null;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "isosplat-viewer": IsosplatViewerElement;
  }
}

if (typeof customElements !== "undefined" && !customElements.get("isosplat-viewer")) {
  customElements.define("isosplat-viewer", IsosplatViewerElement);
}
