import type { StoreInfo } from "../core/types.ts";
import type { SavedSurface, SaveSurfaceOptions } from "../mesh/save_surface.ts";
import type { SceneSource } from "../scene/scene_source.ts";
import type { Source } from "../stream/source.ts";
import { type Progress, StreamError } from "../stream/types.ts";
import { RendererError } from "../viewer/renderer_error.ts";
import { readColour } from "../viewer/setting_text.ts";
import { defaultMode, defaultRate, type Time } from "../viewer/time.ts";
import type { PlayMode } from "../viewer/time_order.ts";
import type { Camera, Clip, LookChange, Projection, Slices, Surface } from "../viewer/types.ts";
import type { Viewer } from "../viewer/viewer.ts";
import { AttributeReaders } from "./attribute_readers.ts";
import { loopOf, projectionOf, rateOf, stepOf, surfacesOf } from "./element_attributes.ts";
import type { IsosplatViewerEvents } from "./element_events.ts";
import { ElementParts } from "./element_parts.ts";
import { listenToPicks } from "./element_pick.ts";
import { ElementView } from "./element_view.ts";
import { ElementViewer } from "./element_viewer.ts";
import { EventElement } from "./event_element.ts";
import { sharedSheet } from "./page_resources.ts";

/** Properties that may have been set before the element was defined. */
const ownProperties =
  "src source scene sceneSource isovalues surfaces camera projection clip slices look step rate loop controls show link".split(
    " ",
  );

/**
 * Shows isosurfaces of a volume, or of several: the layers of a scene, and those of the child elements
 * `<isosplat-layer>`.
 *
 *     <isosplat-viewer src="head.isosplat" isovalue="60.5" controls></isosplat-viewer>
 *     <isosplat-viewer scene="run.isobundle" step="3" controls></isosplat-viewer>
 *
 * Several elements of a page share their workers, their memory, and at most four WebGL contexts: an
 * element without one shows its last picture until it is seen or used again.
 *
 * @attr {string} src - The address of a store (any host that answers Range requests), or of a volume of a server: `https://host/v1/volumes/head`.
 * @attr {string} scene - The address of a scene, which is shown instead of `src`: a bundle, a document `scene.json`, or a scene of a server: `https://host/v1/scenes/run`.
 * @attr {string} step - The number of the first step of a scene that changes with time. Default: 0. The element does not change it.
 * @attr {number} rate - Steps per second while a scene plays, above 0 and at most 60. Default: 5. The controls do not change the attribute.
 * @attr {string} loop - What follows the last step while a scene plays: `loop` (the first one, the default), `swing` (the steps backwards) or `once` (nothing). The controls do not change the attribute.
 * @attr {string} isovalue - One or more isovalues, with commas. Default: the volume's first suggestion, or as in the scene. The element does not change it. Of several volumes, `isovalue`, `colour` and `opacity` are those of `src`, or of the first layer of `scene`.
 * @attr {string} colour - The colours of the surfaces: `d9ccb3,c8553d`.
 * @attr {string} opacity - The opacities of the surfaces, 0 to 1: `0.4,1`.
 * @attr {string} camera - The first camera: `azimuth,elevation,distance,x,y,z[,roll[,field of view]]`, as in the address of the page. Default: the whole volume.
 * @attr {string} projection - `perspective` (the default) or `orthographic`.
 * @attr {string} background - The colour behind the surfaces, `rrggbb`. Default: white.
 * @attr {boolean} controls - Shows a slider and a field for the isovalue, and buttons.
 * @attr {string} show - The overlays above the picture, some of `axes,scale,box,clip`: orientation axes, a scale bar, the volume's box with ticks in mm, the clip box with handles. Default: nothing.
 * @attr {string} lang - The language of the element: `en` or `de`. Default: that of the nearest enclosing element with this attribute, when the element is added to the page. Messages of faults are in English.
 * @attr {string} link - The name of a group. Elements of a group have the same camera, isovalues, clipping, slices and time, or those that are named after a colon: `brains:camera,time` shares some of `camera,isovalues,clip,slices,time`.
 *
 * @fires {CustomEvent<StoreInfo>} opened - The volume, or the scene, is open. Its first surface follows. `detail` is of the first volume.
 * @fires {CustomEvent<Progress>} progress - The streaming progress has changed.
 * @fires {CustomEvent<Progress>} complete - Everything visible is drawn at the level that the view resolves.
 * @fires {CustomEvent<Camera>} camerachange - The camera has moved: by a gesture, by a call, or by the group.
 * @fires {CustomEvent<readonly number[]>} isovaluechange - The isovalues have changed: by the controls, by a call, or by the group.
 * @fires {CustomEvent<Clip>} clipchange - The clipping has changed: by a call, or by the group.
 * @fires {CustomEvent<Slices>} sliceschange - The slices have changed: by a call, or by the group.
 * @fires {CustomEvent<number>} stepchange - Another step is shown: by the controls, by playing, by a call, or by the group.
 * @fires {CustomEvent<PickedSurface>} pick - A surface was clicked, or is in the middle of the picture when Enter is pressed. `detail` has the point, the `name` of its layer, and the `label` with its `volume` and `voxels` if the layer shows one.
 * @fires {CustomEvent<StreamError | RendererError>} fault - Something failed. `detail.message` states the expected value, the found value, and the remedy; the element retries where this can help.
 *
 * @slot - The elements `<isosplat-layer>`, which are not displayed themselves. Others are shown above the picture, such as a caption.
 * @slot poster - Shown until the first surface.
 *
 * @csspart canvas - The picture.
 * @csspart message - The message of a fault.
 * @csspart controls - The bar of controls.
 * @csspart slider - The slider of the isovalue.
 * @csspart field - The field of the isovalue.
 * @csspart units - The units of the isovalue.
 * @csspart button - Each of the buttons.
 * @csspart play - The button that plays a scene.
 * @csspart step - The slider of the steps.
 * @csspart time - The time of the step.
 * @csspart rate - The choice of the rate; hidden in a narrow element.
 * @csspart loop - The choice of what follows the last step; hidden in a narrow element.
 *
 * @cssprop --isosplat-text - The colour of text.
 * @cssprop --isosplat-panel - The background of controls and messages.
 * @cssprop --isosplat-accent - The colour of the slider and of the focus.
 */
export class IsosplatViewerElement extends EventElement<IsosplatViewerEvents> {
  static readonly observedAttributes = [
    "src",
    "scene",
    "step",
    "rate",
    "loop",
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

  #sceneSource: SceneSource | null = null;
  readonly #root = this.attachShadow({ mode: "open" });
  readonly #parts = new ElementParts(this, this.#root, {
    setIsovalue: (isovalue) => this.#view.moveFirst(isovalue),
    changeClip: (clip) => {
      this.clip = clip;
    },
    setStep: (step) => {
      this.step = step;
    },
    setRate: (rate) => {
      this.rate = rate;
    },
    setLoop: (mode) => {
      this.loop = mode;
    },
    togglePlay: () => this.#view.time.togglePlay(),
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
    timeShown: (time) => this.#parts.time.show(time),
  });
  readonly #viewer = new ElementViewer(this, this.#root, this.#parts, this.#view);
  readonly #attributes = new AttributeReaders(this, (error) => this.#viewer.fault(error));

  constructor() {
    super();
    this.#root.adoptedStyleSheets = [sharedSheet()];
    // An element without a context gets one before a gesture on it begins.
    const wake = () => this.#viewer.wake(true);
    this.addEventListener("pointerenter", wake);
    this.addEventListener("pointerdown", wake);
    this.addEventListener("focusin", wake);
    listenToPicks(this, () => this.viewer);
  }

  connectedCallback(): void {
    this.takeProperties(ownProperties);
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
    if (name === "src") this.#viewer.setSource(this.#attributes.source() ?? null);
    else if (name === "scene") {
      this.#sceneSource = null;
      this.#viewer.setScene(this.#attributes.scene() ?? null);
    } else if (name === "step") this.#readStep();
    else if (name === "rate") this.rate = this.#attributes.rate();
    else if (name === "loop") this.loop = this.#attributes.loop();
    else if (name === "camera") this.camera = this.#attributes.camera();
    else if (name === "projection") this.#view.readProjection();
    else if (name === "background") this.look = { background: readColour(now) ?? "#ffffff" };
    else if (name === "controls") this.#parts.controls.element.hidden = now === null;
    else if (name === "show") this.#parts.overlays.show(this.#attributes.show() ?? new Set());
    else if (name === "link") this.#view.relink(this.#attributes.link() ?? null);
    else if (name === "lang") void this.#parts.translate();
    else if (name === "isovalue") this.#view.readIsovalues();
    else this.surfaces = surfacesOf(this, this.isovalues);
  }

  /** The address of the volume: the attribute. */
  get src(): string {
    return this.getAttribute("src") ?? "";
  }
  set src(value: string | null | undefined) {
    this.setText("src", value);
  }

  /** The source of the bytes. Set it instead of `src` for requests with tokens and headers. */
  get source(): Source | null {
    return this.#viewer.source;
  }
  set source(source: Source | null | undefined) {
    this.#viewer.setSource(source ?? null);
  }

  /** The address of the scene: the attribute. */
  get scene(): string {
    return this.getAttribute("scene") ?? "";
  }
  set scene(value: string | null | undefined) {
    this.setText("scene", value);
  }

  /**
   * The source of the scene: of `sceneAt`, `sceneOfFiles` or `bundleScene` of `isosplat/scene`. Set it instead
   * of `scene` for requests with tokens and headers, and for files of the visitor.
   */
  get sceneSource(): SceneSource | null {
    return this.#sceneSource;
  }
  set sceneSource(source: SceneSource | null | undefined) {
    this.#sceneSource = source ?? null;
    this.#viewer.setScene(source ? () => Promise.resolve(source) : null);
  }

  /**
   * The number of the step that is shown, or will be as soon as it has a surface. Numbers beyond the last
   * step mean the last one. Null or undefined: that of the attribute.
   */
  get step(): number {
    return this.#view.time.step;
  }
  set step(step: number | null | undefined) {
    this.#view.time.step = step ?? stepOf(this) ?? 0;
  }

  /**
   * The steps of the scene, with `values`, `unit`, `play()`, `pause()`, `rate` and `mode`: see `Viewer.time`.
   * Null while the element has no WebGL context, and if nothing changes with time.
   */
  get time(): Time | null {
    return this.viewer?.time ?? null;
  }

  /** Steps per second while a scene plays, above 0 and at most 60. Null or undefined: that of the attribute. Throws a RangeError. */
  get rate(): number {
    return this.#view.time.rate;
  }
  set rate(rate: number | null | undefined) {
    this.#view.time.rate = rate ?? rateOf(this) ?? defaultRate;
  }

  /** What follows the last step while a scene plays. Null or undefined: that of the attribute. Throws a RangeError. */
  get loop(): PlayMode {
    return this.#view.time.mode;
  }
  set loop(mode: PlayMode | null | undefined) {
    this.#view.time.mode = mode ?? loopOf(this) ?? defaultMode;
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
    this.setText("show", value || null);
  }

  /** The name of the group: the attribute. */
  get link(): string {
    return this.getAttribute("link") ?? "";
  }
  set link(value: string) {
    this.setText("link", value || null);
  }

  /**
   * The isovalues. New ones keep the colours of the existing surfaces. Null or undefined: those of
   * the attribute, else the volume's first suggestion.
   */
  get isovalues(): readonly number[] {
    return this.#view.isovalues;
  }
  set isovalues(requested: readonly number[] | null | undefined) {
    this.#view.isovalues = requested;
  }

  /** The isosurfaces with their colours and opacities. Null or undefined: those of the attributes. */
  get surfaces(): readonly Surface[] {
    return this.#view.surfaces;
  }
  set surfaces(requested: readonly Surface[] | null | undefined) {
    this.#view.surfaces = requested;
  }

  /** Null until a volume is open, or a camera is set. */
  get camera(): Camera | null {
    return this.#view.camera;
  }
  set camera(requested: Camera | null | undefined) {
    this.#view.camera = requested;
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
  set clip(requested: Clip | null | undefined) {
    this.#view.clip = requested;
  }

  /**
   * Planes that show the volume's values where cells are loaded, and are hatched elsewhere. `along`
   * has the positions across x, y and z, as fractions of the volume or null; `plane` is an oblique
   * plane; `range` has the values shown as black and white. Null or undefined: none.
   */
  get slices(): Slices {
    return this.#view.slices;
  }
  set slices(requested: Slices | null | undefined) {
    this.#view.slices = requested;
  }

  /**
   * Splats, colouring, background and light. A new value changes only the settings that it
   * contains. `{ colourBy: "field", field: { name: "pressure" } }` colours by a field of the store; its
   * member `lines: 50` draws contour lines at the multiples of 50.
   */
  get look(): LookChange {
    return this.#view.look;
  }
  set look(change: LookChange | null | undefined) {
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
    const { surfaceOf } = await import("./saved_surface.ts");
    return surfaceOf(this, options);
  }

  #readStep(): void {
    const step = this.#attributes.step();
    if (typeof step === "number") this.step = step;
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
