import type { SavedSurface, SaveSurfaceOptions } from "../mesh/index.ts";
import {
  type Decoder,
  faults,
  type Progress,
  type Source,
  type StoreInfo,
  StreamError,
  slowWait,
  WorkerPool,
} from "../stream/index.ts";
import { elementTextsIn } from "../texts/element.ts";
import type { Language } from "../texts/languages.ts";
import {
  type Camera,
  type Clip,
  compiledRenderer,
  firstSurface,
  type Look,
  noSlices,
  type Projection,
  RendererError,
  readCamera,
  readColour,
  readColours,
  readNumbers,
  readOpacities,
  readProjection,
  type Slices,
  type Surface,
  surfacesAt,
  Viewer,
  wholeVolume,
  writeCamera,
} from "../viewer/index.ts";
import { ContextPool, type ContextUser } from "./context_pool.ts";
import { ControlsBar } from "./controls_bar.ts";
import type { IsosplatViewerEvents } from "./element_events.ts";
import { languageOf } from "./element_language.ts";
import { sourceOf } from "./element_source.ts";
import { type LinkedElement, type LinkedView, LinkGroups } from "./link_groups.ts";
import { OverlayArea, readParts, shownParts } from "./overlay_area.ts";
import { PictureArea, stillOf } from "./picture_area.ts";
import { sameValue } from "./same_value.ts";
import { styles } from "./styles.ts";

/** Properties that may have been set before the element was defined. */
const ownProperties =
  "src source isovalues surfaces camera projection clip slices look controls show link".split(" ");

/** How long the renderer may take to arrive before the element says so. */
const startLimitMs = 4000;

/** Servers that render pages have no elements: there this module can be imported, and does nothing. */
const BaseElement: typeof HTMLElement = globalThis.HTMLElement ?? class {};

/** WebGL contexts of the elements of a page together. */
const mostContexts = 4;

const contexts = new ContextPool(mostContexts);
const groups = new LinkGroups();

/** The style sheet that all elements share. */
let sheet: CSSStyleSheet | null = null;
function newSheet(): CSSStyleSheet {
  const made = new CSSStyleSheet();
  made.replaceSync(styles);
  return made;
}

/** The workers that all elements share. They live as long as the page. */
let workers: WorkerPool | null = null;
function sharedWorkers(): Decoder {
  workers ??= new WorkerPool({ renderer: compiledRenderer() });
  return workers;
}

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
 * @attr {string} show - What is shown above the picture, some of `axes,scale,box,clip`: orientation axes, a scale bar, the volume's box with ticks in mm, the clip box with handles. Default: nothing.
 * @attr {string} lang - The language of the element: `en` or `de`. Default: that of the element around it that has one, when the element is added to the page. Messages of faults are English.
 * @attr {string} link - The name of a group. Elements of a group have the same camera, isovalues, clipping and slices.
 *
 * @fires {CustomEvent<StoreInfo>} opened - A volume is open. Its first surface follows.
 * @fires {CustomEvent<Progress>} progress - The streaming progress has changed.
 * @fires {CustomEvent<Progress>} complete - Everything visible is drawn at the level that the view resolves.
 * @fires {CustomEvent<Camera>} camerachange - The camera moved: by a gesture, by a call, or by the group.
 * @fires {CustomEvent<readonly number[]>} isovaluechange - The isovalues have changed: by the controls, by a call, or by the group.
 * @fires {CustomEvent<Clip>} clipchange - The clipping has changed: by a call, or by the group.
 * @fires {CustomEvent<Slices>} sliceschange - The slices have changed: by a call, or by the group.
 * @fires {CustomEvent<StreamError | RendererError>} fault - Something failed. `detail.message` says what was expected, what was found, and the remedy; the element tries again where that can help.
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
export class IsosplatViewerElement extends BaseElement {
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
  readonly #user = this.#asContextUser();
  readonly #linked: LinkedElement = { receive: (view) => this.#receive(view) };
  readonly #picture = new PictureArea(() => this.getAttribute("aria-label"));
  readonly #overlays = new OverlayArea(
    (clip) => {
      this.clip = clip;
    },
    (error) => {
      const text = `what show="${this.show}" names could not be loaded: ${String(error)}`;
      this.#fault(new StreamError("unreachable", text, error));
    },
  );
  readonly #poster = document.createElement("slot");
  readonly #message = document.createElement("div");
  readonly #controls: ControlsBar;
  readonly #sight = new IntersectionObserver((entries) => this.#seen(entries), {
    rootMargin: "100px",
  });

  #language: Language = "en";
  #viewer: Viewer | null = null;
  #sampleBudget = 0;
  #source: Source | null = null;
  #opening: AbortController | null = null;
  #reopenTimer = 0;
  #failures = 0;
  #isVisible = false;
  #hasPicture = false;
  #wasComplete = false;
  /** The volume of the last `#open()` is open, and set to the element's view. */
  #isOpen = false;
  #isAttached = false;
  /** Not 0 while the viewer is being set to a view of the group, which is not sent back. */
  #receiving = 0;

  #info: StoreInfo | null = null;
  #progress: Progress | null = null;
  #camera: Camera | null = null;
  /** Empty until the attribute, a call or the volume has isovalues. */
  #surfaces: readonly Surface[] = [];
  #clip: Clip = wholeVolume;
  #slices: Slices = noSlices;
  /** What attributes, calls, gestures or the group have set; the volume's defaults are not in it. */
  #chosen: LinkedView = {};
  #look: Partial<Look> = {};

  constructor() {
    super();
    // A style element would need style-src 'unsafe-inline'.
    sheet ??= newSheet();
    this.#root.adoptedStyleSheets = [sheet];
    this.#poster.name = "poster";
    this.#poster.className = "poster";
    this.#message.className = "message";
    this.#message.setAttribute("part", "message");
    this.#message.setAttribute("role", "status");
    this.#message.hidden = true;
    this.#controls = new ControlsBar({
      setIsovalue: (value) => this.#moveFirst(value),
      reset: () => this.reset(),
      toggleFullScreen: () => void this.#toggleFullScreen(),
    });
    this.#root.append(
      this.#picture.element,
      this.#overlays.element,
      this.#poster,
      document.createElement("slot"),
      this.#controls.element,
      this.#message,
    );
    // An element without a context gets one before a gesture on it begins.
    const wake = () => this.#wake(true);
    this.addEventListener("pointerenter", wake);
    this.addEventListener("pointerdown", wake);
    this.addEventListener("focusin", wake);
  }

  connectedCallback(): void {
    for (const name of ownProperties) this.#takeProperty(name);
    this.#picture.setFocusable(true);
    void this.#translate();
    this.#sight.observe(this);
    this.#isAttached = true;
    this.#join();
  }

  disconnectedCallback(): void {
    this.#sight.disconnect();
    this.#isVisible = false;
    this.#isAttached = false;
    if (this.link) groups.leave(this.link, this.#linked);
    this.#close();
    this.#picture.removeStill();
    this.#overlays.clear();
    this.#hasPicture = false;
    this.#poster.hidden = false;
    contexts.release(this.#user);
  }

  attributeChangedCallback(name: string, before: string | null, now: string | null): void {
    if (before === now) return;
    if (name === "src") this.#setSource(now === null ? null : this.#sourceOf(now));
    else if (name === "camera") this.#readCamera(now);
    else if (name === "projection") this.#setProjection();
    else if (name === "background") this.look = { background: readColour(now) ?? "#ffffff" };
    else if (name === "controls") this.#controls.element.hidden = now === null;
    else if (name === "show") this.#readShow(now);
    else if (name === "link") this.#relink(before);
    else if (name === "lang") void this.#translate();
    else if (name === "isovalue") this.#readIsovalues();
    else this.surfaces = surfacesAt(this.isovalues, this.#colours(), this.#opacities());
  }

  /** The address of the volume: the attribute. */
  get src(): string {
    return this.getAttribute("src") ?? "";
  }
  set src(value: string | null | undefined) {
    if (typeof value === "string") this.setAttribute("src", value);
    else this.removeAttribute("src");
  }

  /** Where the bytes come from. Set it in place of `src` for tokens and headers of requests. */
  get source(): Source | null {
    return this.#source;
  }
  set source(source: Source | null | undefined) {
    this.#setSource(source ?? null);
  }

  /** Shows the controls: the attribute. */
  get controls(): boolean {
    return this.hasAttribute("controls");
  }
  set controls(value: boolean) {
    this.toggleAttribute("controls", value);
  }

  /** What is shown above the picture: the attribute. */
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
   * The isovalues. New ones keep the colours of the surfaces that are there. Null or undefined: those
   * of the attribute, else the volume's first suggestion.
   */
  get isovalues(): readonly number[] {
    return this.#surfaces.map(({ isovalue }) => isovalue);
  }
  set isovalues(asked: readonly number[] | null | undefined) {
    const isovalues = asked ?? this.#firstIsovalues();
    const defaults = surfacesAt(isovalues, this.#colours(), this.#opacities());
    this.surfaces = defaults.map((surface, i) => ({
      ...(this.#surfaces[i] ?? surface),
      isovalue: surface.isovalue,
    }));
  }

  /** The isosurfaces with their colours and opacities. Null or undefined: those of the attributes. */
  get surfaces(): readonly Surface[] {
    return this.#surfaces;
  }
  set surfaces(asked: readonly Surface[] | null | undefined) {
    const before = this.isovalues;
    this.#surfaces = asked
      ? [...asked]
      : surfacesAt(this.#firstIsovalues(), this.#colours(), this.#opacities());
    this.#viewer?.setSurfaces(this.#surfaces);
    this.#showControls();
    const { isovalues } = this;
    if (isovalues.length === before.length && isovalues.every((v, i) => v === before[i])) return;
    this.#wake();
    this.#changed("isovaluechange", isovalues, { isovalues });
  }

  /** Null until a volume is open, or a camera is set. */
  get camera(): Camera | null {
    return this.#camera;
  }
  set camera(asked: Camera | null | undefined) {
    if (!asked) return;
    const camera = { ...asked, projection: asked.projection ?? this.projection };
    this.#camera = camera;
    // The attribute is what the picture has; its callback finds the camera as it is.
    if (camera.projection !== this.projection) this.projection = camera.projection;
    this.#wake();
    if (this.#viewer) this.#viewer.setCamera(camera);
    else this.#changed("camerachange", camera, { camera });
  }

  /** Perspective or orthographic: the attribute. */
  get projection(): Projection {
    return readProjection(this.getAttribute("projection")) ?? "perspective";
  }
  set projection(projection: Projection) {
    this.setAttribute("projection", projection);
  }

  /** The part of the volume that is shown. Null or undefined: all of it. */
  get clip(): Clip {
    return this.#clip;
  }
  set clip(asked: Clip | null | undefined) {
    const clip = asked ?? wholeVolume;
    this.#clip = clip;
    this.#viewer?.setClip(clip);
    this.#overlays.clipChanged();
    this.#wake();
    this.#changed("clipchange", clip, { clip });
  }

  /**
   * Planes that show the volume's values where cells are loaded, hatched elsewhere: `along` has the places
   * across x, y and z, as fractions of the volume or null, `plane` an oblique one, `range` the values that are
   * black and white. Null or undefined: none.
   */
  get slices(): Slices {
    return this.#slices;
  }
  set slices(asked: Slices | null | undefined) {
    const slices = asked ?? noSlices;
    if (sameValue(slices, this.#slices)) return;
    this.#slices = slices;
    this.#viewer?.setSlices(slices);
    this.#wake();
    this.#changed("sliceschange", slices, { slices });
  }

  /** Splats, colouring, background and light. What is set is added to what was set before. */
  get look(): Partial<Look> {
    return this.#look;
  }
  set look(change: Partial<Look> | null | undefined) {
    this.#look = { ...this.#look, ...change };
    this.#viewer?.setLook(this.#look);
    this.#wake();
  }

  /** The open volume; null before the first. */
  get info(): StoreInfo | null {
    return this.#info;
  }

  /** The last progress; null before the first. */
  get progress(): Progress | null {
    return this.#progress;
  }

  /** The viewer on the canvas; null while the element has no WebGL context. */
  get viewer(): Viewer | null {
    return this.#viewer;
  }

  /** Returns to the first view of the volume. */
  reset(): void {
    this.#wake(true);
    this.#viewer?.reset();
  }

  /** Retries at once what waits for its next attempt. */
  retry(): void {
    if (this.#info || !this.#viewer) this.#viewer?.retry();
    else void this.#open();
  }

  /** The picture as a PNG, at the resolution of the canvas. Rejects if there is none. */
  async screenshot(): Promise<Blob> {
    if (!this.#viewer) throw new RendererError("nothing is drawn: the element is out of sight");
    return this.#viewer.screenshot();
  }

  /**
   * The first surface as a file of triangles, at full detail unless `options` say otherwise: see
   * `saveSurface` of `isosplat/mesh`. Rejects if no volume is open.
   */
  async saveSurface(options: SaveSurfaceOptions = {}): Promise<SavedSurface> {
    const isovalue = this.isovalues[0];
    const access = this.#viewer?.storeAccess;
    const source = this.#source;
    if (isovalue === undefined || !source) throw new Error("no volume is open");
    const { SurfaceReader, saveSurface } = await import("../mesh/index.ts");
    return saveSurface(access ? new SurfaceReader(access) : source, isovalue, options);
  }

  override addEventListener<K extends keyof IsosplatViewerEvents>(
    type: K,
    listener: (this: IsosplatViewerElement, event: IsosplatViewerEvents[K]) => unknown,
    options?: boolean | AddEventListenerOptions,
  ): void;
  override addEventListener<K extends keyof HTMLElementEventMap>(
    type: K,
    listener: (this: HTMLElement, event: HTMLElementEventMap[K]) => unknown,
    options?: boolean | AddEventListenerOptions,
  ): void;
  override addEventListener(
    type: string,
    listener: EventListenerOrEventListenerObject,
    options?: boolean | AddEventListenerOptions,
  ): void;
  override addEventListener(
    type: string,
    // biome-ignore lint/suspicious/noExplicitAny: the overloads state the types
    listener: any,
    options?: boolean | AddEventListenerOptions,
  ): void {
    super.addEventListener(type, listener, options);
  }

  // ---- The pool of contexts and the groups ----

  #asContextUser(): ContextUser {
    const isVisible = () => this.#isVisible;
    const isBusy = () => this.#viewer?.isBusy ?? false;
    const isFocused = () => this.matches(":focus-within");
    return {
      get isVisible() {
        return isVisible();
      },
      get isBusy() {
        return isBusy();
      },
      get isFocused() {
        return isFocused();
      },
      grant: (sampleBudget) => {
        this.#sampleBudget = sampleBudget;
        try {
          this.#viewer = this.#newViewer();
          this.#overlays.attach(this.#viewer);
        } catch (error) {
          this.#fault(faultOf(error));
        }
        void this.#open();
      },
      setSampleBudget: (samples) => {
        this.#sampleBudget = samples;
        this.#viewer?.setSampleBudget(samples);
      },
      suspend: () => this.#suspend(),
    };
  }

  async #suspend(): Promise<void> {
    // Null if nothing has been drawn in this context: an older picture stays.
    const still = this.#viewer && this.#hasPicture ? await stillOf(this.#viewer) : null;
    // The focus may have come while the picture was being made.
    const { activeElement } = this.#root;
    const hadFocus = activeElement !== null && activeElement === this.#viewer?.canvas;
    this.#close();
    if (hadFocus) this.#picture.element.focus({ preventScroll: true });
    if (!still) return;
    if (this.isConnected && this.#hasPicture) {
      this.#picture.setStill(still);
    } else URL.revokeObjectURL(still.src);
  }

  #receive({ camera, isovalues, clip, slices }: LinkedView): void {
    this.#receiving++;
    try {
      if (camera) this.camera = camera;
      if (isovalues) this.isovalues = isovalues;
      if (clip) this.clip = clip;
      if (slices) this.slices = slices;
    } finally {
      this.#receiving--;
    }
  }

  // ---- Attributes and properties ----

  /** A property that was set before the element was defined is an own property: sets it again. */
  #takeProperty(name: string): void {
    if (!Object.hasOwn(this, name)) return;
    const element = this as unknown as Record<string, unknown>;
    const value = element[name];
    delete element[name];
    element[name] = value;
  }

  async #translate(): Promise<void> {
    const language = languageOf(this);
    if (language === this.#language) return;
    this.#language = language;
    const { element, overlay } = await elementTextsIn(language);
    if (language !== this.#language) return; // another was set in the meantime
    this.#controls.translate(language, element);
    this.#picture.translate(element);
    this.#overlays.translate(overlay);
  }

  #colours(): string[] | undefined {
    return readColours(this.getAttribute("colour") ?? "");
  }

  #opacities(): number[] | undefined {
    return readOpacities(this.getAttribute("opacity") ?? "");
  }

  /** Returns the isovalues of the attribute. Without it, the surfaces stay as they are. */
  #readIsovalues(): readonly number[] | undefined {
    const isovalues = readNumbers(this.getAttribute("isovalue"));
    if (isovalues) this.surfaces = surfacesAt(isovalues, this.#colours(), this.#opacities());
    return isovalues;
  }

  /** Those that an element has by its attribute, or by the volume once it is open. */
  #firstIsovalues(): readonly number[] {
    const isovalues = readNumbers(this.getAttribute("isovalue"));
    if (isovalues) return isovalues;
    return this.#info ? [firstSurface(this.#info).isovalue] : [];
  }

  #readCamera(text: string | null): void {
    const camera = readCamera(text);
    if (camera) this.camera = { ...camera, projection: this.projection };
    else if (text) this.#fault(expected("camera", text, "azimuth,elevation,distance,x,y,z"));
  }

  #readShow(text: string | null): void {
    const parts = readParts(text);
    this.#overlays.show(parts ?? new Set());
    if (!parts) this.#fault(expected("show", text ?? "", `some of ${shownParts.join(",")}`));
  }

  #setProjection(): void {
    const { projection } = this;
    const camera = this.#camera;
    if (camera && (camera.projection ?? "perspective") !== projection) {
      this.camera = { ...camera, projection };
    }
  }

  #sourceOf(src: string): Source | null {
    const source = sourceOf(src, document.baseURI);
    if (!source) this.#fault(expected("src", src, "the http or https address of a store"));
    return source ?? null;
  }

  #setSource(source: Source | null): void {
    const isFirst = this.#source === null;
    this.#source = source;
    this.#info = null;
    if (!isFirst) this.#resetView();
    if (!source) this.#viewer?.close();
    else {
      if (this.#viewer) void this.#open();
      this.#wake();
    }
  }

  /** Another volume has the view of the attributes, of the group, or its own. */
  #resetView(): void {
    this.#hasPicture = false;
    this.#poster.hidden = false;
    if (this.link) groups.leave(this.link, this.#linked);
    const read = readCamera(this.getAttribute("camera"));
    const camera = read && { ...read, projection: this.projection };
    this.#camera = camera ?? null;
    const isovalues = this.#readIsovalues();
    if (!isovalues) this.#surfaces = [];
    // Isovalues and the range of slices are values of the volume before.
    const { range, ...planes } = this.#slices;
    if (range) {
      this.#slices = planes;
      this.#viewer?.setSlices(planes);
    }
    const { clip } = this.#chosen;
    const slices = this.#chosen.slices && this.#slices;
    this.#chosen = {
      ...(camera && { camera }),
      ...(isovalues && { isovalues }),
      ...(clip && { clip }),
      ...(slices && { slices }),
    };
    if (this.#isAttached) this.#join();
  }

  #relink(before: string | null): void {
    if (before) groups.leave(before, this.#linked);
    if (this.#isAttached) this.#join();
  }

  #join(): void {
    if (this.link) this.#receive(groups.join(this.link, this.#linked, this.#chosen));
  }

  /** Reports a change to listeners; and to the group, unless it came from there or from opening. */
  #changed<K extends keyof IsosplatViewerEvents>(
    name: K,
    detail: IsosplatViewerEvents[K]["detail"],
    view: LinkedView,
  ): void {
    const isOpening = this.#viewer?.info && !this.#isOpen;
    if (!isOpening) {
      Object.assign(this.#chosen, view);
      if (this.link && this.#receiving === 0) groups.send(this.link, this.#linked, view);
    }
    this.dispatchEvent(new CustomEvent(name, { detail }));
  }

  // ---- The viewer ----

  #seen(entries: readonly IntersectionObserverEntry[]): void {
    this.#isVisible = entries.at(-1)?.isIntersecting ?? false;
    if (this.#viewer) contexts.changed();
    else if (this.#isVisible) this.#wake();
    else contexts.release(this.#user);
  }

  /** Something is to be drawn, or a visitor is about to use the element (isUrgent). */
  #wake(isUrgent = false): void {
    if (this.#isVisible && this.#source) contexts.request(this.#user, isUrgent);
  }

  #newViewer(): Viewer {
    const hasFocus = this.#root.activeElement === this.#picture.element;
    const canvas = this.#picture.addCanvas(hasFocus);
    this.#hasPicture = false;
    const viewer = new Viewer(canvas, {
      decoder: sharedWorkers(),
      sampleBudget: this.#sampleBudget,
    });
    viewer.setLook(this.#look);
    viewer.setClip(this.#clip);
    viewer.setSlices(this.#slices);
    viewer.on("progress", (progress) => this.#onProgress(progress));
    viewer.on("frame", ({ samplesDrawn }) => {
      if (samplesDrawn > 0) this.#onPicture();
    });
    viewer.on("camera", (camera) => {
      this.#camera = camera;
      contexts.request(this.#user);
      this.#changed("camerachange", camera, { camera });
    });
    viewer.on("opened", (info) => this.#onOpened(info));
    viewer.on("busy", () => contexts.changed());
    viewer.on("error", (error) => this.#fault(error));
    return viewer;
  }

  async #open(): Promise<void> {
    const viewer = this.#viewer;
    const source = this.#source;
    if (!viewer || !source) return;
    clearTimeout(this.#reopenTimer);
    this.#opening?.abort();
    const opening = new AbortController();
    this.#opening = opening;
    this.#wasComplete = false;
    this.#isOpen = false;
    source.forget();
    this.#reportLateRenderer(opening.signal);
    try {
      await viewer.open(source, {
        ...(this.#surfaces.length > 0 && { surfaces: this.#surfaces }),
        ...(this.#camera && { camera: this.#camera }),
        projection: this.projection,
        signal: opening.signal,
      });
    } catch (error) {
      if (opening.signal.aborted) return;
      const fault = faultOf(error);
      this.#fault(fault);
      if (faults[fault.kind].retry === "never") return;
      this.#reopenTimer = window.setTimeout(() => void this.#open(), slowWait(this.#failures++));
    }
  }

  /** A request that is never answered causes no error. */
  #reportLateRenderer(signal: AbortSignal): void {
    const timer = setTimeout(() => {
      if (signal.aborted) return;
      const text = `the renderer has not arrived for ${startLimitMs / 1000} s; still waiting for it`;
      this.#fault(new RendererError(text, "unreachable"));
    }, startLimitMs);
    const end = () => clearTimeout(timer);
    compiledRenderer().then(end, end);
  }

  /** Ends everything that runs, and frees the context. */
  #close(): void {
    clearTimeout(this.#reopenTimer);
    this.#opening?.abort();
    this.#opening = null;
    const viewer = this.#viewer;
    this.#viewer = null;
    if (!viewer) return;
    this.#overlays.attach(null);
    viewer.dispose();
    const { canvas } = viewer;
    // The browser would free the context only when it collects the canvas as garbage.
    canvas.getContext("webgl2")?.getExtension("WEBGL_lose_context")?.loseContext();
    canvas.remove();
    this.#picture.setFocusable(true);
  }

  #onOpened(info: StoreInfo): void {
    this.#info = info;
    this.#failures = 0;
    this.#message.hidden = true;
    this.#controls.opened(info);
    // Both may have been set while the volume was being opened.
    if (this.#surfaces.length > 0) this.#viewer?.setSurfaces(this.#surfaces);
    else this.isovalues = this.#viewer?.surfaces.map(({ isovalue }) => isovalue) ?? [];
    const camera = this.#viewer?.camera ?? null;
    if (!this.#camera) this.#camera = camera;
    else if (writeCamera(this.#camera) !== (camera && writeCamera(camera))) {
      this.#viewer?.setCamera(this.#camera);
    }
    this.#isOpen = true;
    this.#showControls();
    this.dispatchEvent(new CustomEvent("opened", { detail: info }));
  }

  #onProgress(progress: Progress): void {
    this.#progress = progress;
    this.dispatchEvent(new CustomEvent("progress", { detail: progress }));
    if (progress.complete && !this.#wasComplete) {
      this.dispatchEvent(new CustomEvent("complete", { detail: progress }));
    }
    this.#wasComplete = progress.complete;
    if (!progress.fault) this.#message.hidden = true;
  }

  #onPicture(): void {
    this.#hasPicture = true;
    this.#poster.hidden = true;
    this.#picture.removeStill();
  }

  #fault(error: StreamError | RendererError): void {
    this.#message.textContent = error.message;
    this.#message.hidden = false;
    this.dispatchEvent(new CustomEvent("fault", { detail: error }));
  }

  #moveFirst(isovalue: number): void {
    const [low, high] = this.#info?.range ?? [isovalue, isovalue];
    const inside = Math.max(low, Math.min(high, isovalue));
    this.isovalues = [inside, ...this.isovalues.slice(1)];
    this.#showControls();
  }

  #showControls(): void {
    const [first] = this.isovalues;
    if (first !== undefined) this.#controls.show(first);
  }

  async #toggleFullScreen(): Promise<void> {
    try {
      if (document.fullscreenElement) await document.exitFullscreen();
      else await this.requestFullscreen();
    } catch {
      // The page, or the frame around it, does not allow it.
    }
  }
}

function faultOf(error: unknown): StreamError | RendererError {
  if (error instanceof StreamError || error instanceof RendererError) return error;
  const message = error instanceof Error ? error.message : String(error);
  return new RendererError(message, "internal", error);
}

function expected(name: string, found: string, what: string): StreamError {
  return new StreamError("bad-address", `${name}="${found}": expected ${what}`);
}

declare global {
  interface HTMLElementTagNameMap {
    "isosplat-viewer": IsosplatViewerElement;
  }
}

if (typeof customElements !== "undefined" && !customElements.get("isosplat-viewer")) {
  customElements.define("isosplat-viewer", IsosplatViewerElement);
}
