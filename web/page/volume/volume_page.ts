import { render } from "lit";
import type { ClipHandles } from "../../overlay/clip_handles.ts";
import type { Overlay } from "../../overlay/overlay.ts";
import {
  faults,
  type Progress,
  type StoreInfo,
  StreamError,
  slowWait,
} from "../../stream/index.ts";
import { listed } from "../../texts/numbers.ts";
import { pageTexts } from "../../texts/page.ts";
import {
  type AxisView,
  axisViews,
  type Camera,
  CameraMotion,
  cameraAlong,
  RendererError,
  writeCamera,
} from "../../viewer/index.ts";
import { AddressBar, type AddressState, addressOf } from "../address/page_address.ts";
import type { Target } from "../address/target.ts";
import { keptSessionKey, readUrl, writeUrl } from "../address/url_state.ts";
import { ViewHistory } from "../address/view_history.ts";
import type { CaptureDialog } from "../capture/capture_dialog.ts";
import type { Measure } from "../measure/measure.ts";
import { DisplaySettings } from "../panel/display_settings.ts";
import { Histogram } from "../panel/histogram.ts";
import { formatValue, plainValue } from "../shell/format.ts";
import { kindOf, type Problem, problemOf, problemOfFault } from "../shell/problems.ts";
import { onTheme, toggleTheme } from "../shell/theme.ts";
import { keepThumbnailWhenIdle } from "../shell/thumbnails.ts";
import { Toast } from "../shell/toast.ts";
import { fetchVolumes } from "../shell/volumes_api.ts";
import { handlePageKey, historyStep } from "./page_keys.ts";
import { StatusLine } from "./status_line.ts";
import { takeView } from "./view.ts";
import {
  type Banner,
  type LayoutActions,
  type LayoutState,
  volumeLayout,
} from "./volume_layout.ts";

/**
 * The page of one volume: opens it, shows its progress and lays out the page. Owns the viewer and
 * the address.
 */
export class VolumePage {
  readonly root: HTMLElement;
  #target: Target;
  readonly #view = takeView(() => this.#reset());
  readonly #canvas = this.#view.canvas;
  readonly #viewer = this.#view.viewer;
  readonly #status = new StatusLine();
  readonly #search = location.search;
  readonly #url = readUrl(this.#search);
  readonly #motion = new CameraMotion(this.#viewer);
  #overlay: Overlay | null = null;
  #clipHandles: ClipHandles | null = null;
  #isClipBoxShown = false;
  #measure: Measure | null = null;
  #loadingMeasure: Promise<void> | null = null;
  #slicesSection: LayoutState["slicesSection"] = null;
  #capture: Promise<CaptureDialog> | null = null;
  #tools: HTMLElement | null = null;
  readonly #settings = new DisplaySettings(this.#viewer, this.#url, () => {
    this.#address.changed();
    this.#render();
  });
  readonly #histogram = new Histogram({
    pick: (value) => this.#settings.actions.slide(value),
    activate: (index) => this.#settings.actions.activate(index),
    step: (by) => this.#settings.step(by, "step"),
  });
  readonly #toast = new Toast(() => this.#render());
  readonly #listeners = new AbortController();

  #info: StoreInfo | null = null;
  #camera: Camera | null = null;
  /** The camera that the viewer chose, if the address has none. */
  #firstCamera: Camera | null = null;
  readonly #history = new ViewHistory<AddressState>();

  /** Why the volume could not be opened. */
  #problem: Problem | null = null;
  #reopenTimer = 0;
  /** Number of consecutive failures to open it. */
  #failures = 0;
  #names: string[] = [];
  #progress: Progress | null = null;
  /** The renderer's last error, until it draws again. */
  #rendererError: RendererError | null = null;
  #isContextLost = false;
  /** The bytes of an isovalue. */
  #cost: { isovalue: number; bytes: number } | null = null;
  #isSheetOpen = false;
  #isPanelHidden = false;
  #hasPicture = false;
  #keptThumbnail = "";
  #renderHandle = 0;
  readonly #address = new AddressBar(
    () =>
      this.#info
        ? {
            volume: this.#url.volume,
            src: this.#url.src,
            ...this.#settings.state,
            camera: this.#restingCamera,
            isDefaultCamera: this.#isDefaultCamera,
            measures: this.#measure?.lines ?? this.#url.measures ?? [],
          }
        : null,
    () => this.#showBusy(),
    (settings, view, hasMeasures) => {
      this.#history.rested(settings, view);
      this.#measure?.rested(hasMeasures);
      this.#render();
    },
  );

  /** Resolves when there is something to see: a surface or an error message. */
  readonly firstContent: Promise<void>;
  #resolveFirstContent = () => {};

  constructor(root: HTMLElement, target: Target) {
    this.root = root;
    this.#target = target;
    this.#listen();
    this.firstContent = new Promise((resolve) => {
      this.#resolveFirstContent = resolve;
    });
    // Starts requests and workers before the page is laid out.
    void this.#open();
    this.#renderNow();
  }

  #listen(): void {
    const viewer = this.#viewer;
    viewer.on("progress", (progress) => {
      // Errors of chunks that were lost with the context.
      if (this.#isContextLost) return;
      this.#status.progress(progress);
      const before = this.#progress;
      this.#progress = progress;
      const isOther =
        before?.fault?.kind !== progress.fault?.kind || before?.state !== progress.state;
      if (isOther) this.#render();
      if (progress.state === "complete" || progress.state === "limited") this.#keepThumbnail();
    });
    viewer.on("frame", (frame) => {
      this.#status.frame(frame);
      if (this.#rendererError) {
        this.#rendererError = null;
        this.#render();
      }
      if (!this.#hasPicture && frame.samplesDrawn > 0) {
        this.#hasPicture = true;
        this.#render();
        // The browser has shown it in the frame after the next.
        requestAnimationFrame(() => requestAnimationFrame(this.#resolveFirstContent));
      }
    });
    viewer.on("opened", (info) => this.#onOpened(info));
    viewer.on("replaced", (info) => {
      this.#settings.opened(info);
      this.#toast.note(pageTexts.replaced);
    });
    viewer.on("camera", (camera) => {
      this.#camera = camera;
      this.#address.changed();
    });
    viewer.on("busy", (isBusy) => {
      if (!isBusy) {
        this.#status.rests();
        this.#findCost();
      }
      this.#showBusy();
    });
    viewer.on("error", (error) => this.#onViewerError(error));
    viewer.on("context", (state) => {
      this.#isContextLost = state === "lost";
      // The complete picture no longer exists.
      this.#resetProgress();
      this.#render();
    });
    onTheme(() => {
      this.#settings.themeChanged();
      this.#histogram.draw();
      this.#renderNow();
    });
    // The point of the surface becomes the centre of rotation.
    this.#canvas.addEventListener("dblclick", ({ clientX, clientY }) => {
      if (this.#measure?.tool.kind) return;
      const box = this.#canvas.getBoundingClientRect();
      const point = viewer.pick(clientX - box.left, clientY - box.top);
      const { camera } = viewer;
      if (point && camera) this.#motion.to({ ...camera, target: point.position });
    });
    const { signal } = this.#listeners;
    const key = (event: KeyboardEvent) => {
      const step = historyStep(event, this.#canvas);
      if (step) {
        event.preventDefault();
        this.#restore(step);
      }
      handlePageKey(event, this.#canvas, viewer, this.#keys);
    };
    window.addEventListener("keydown", key, { signal });
  }

  /**
   * Shows another store of the same volume, with the present view: camera, settings and steps of undo
   * stay, and the picture until the other store has one. An isovalue that the page has chosen is chosen
   * anew. `src`: the store's address; default: as it is.
   */
  replace(target: Target, src = this.#url.src): Promise<void> {
    this.#address.write(); // what has not come to rest is a step of undo as well
    this.#history.replacePresent();
    this.#target = target;
    if (src !== undefined) this.#url.src = src;
    return this.#open({ keepsView: true });
  }

  /** `again`: the message of the last try stays until this one succeeds. */
  async #open({ again = false, keepsView = false } = {}): Promise<void> {
    clearTimeout(this.#reopenTimer);
    if (!again) {
      this.#problem = null;
      this.#failures = 0;
    }
    this.#resetProgress();
    if (!keepsView) {
      this.#settings.closed();
      this.#rendererError = null;
      this.#hasPicture = false;
    }
    document.title = `${this.#target.name} · Isosplat`;
    this.#render();
    try {
      const surfaces = this.#settings.hasSuggested ? [] : this.#settings.surfaces;
      const before = this.#camera;
      const present = keepsView ? this.#viewer.camera : null;
      const camera = present ?? before ?? this.#urlCamera;
      const { projection } = this.#url;
      const source = this.#target.source();
      // The fault may be in cached data.
      if (again) source.bypassCaches();
      const info = await this.#viewer.open(source, {
        ...(surfaces.length > 0 ? { surfaces } : {}),
        ...(camera ? { camera } : {}),
        ...(projection && { projection }),
      });
      if (!camera && !this.#camera) this.#firstCamera = this.#viewer.camera;
      const notes = this.#settings.opened(info);
      if (keepsView) return;
      notes.unshift(...(this.#url.notes ?? []));
      const isMoved = this.#camera !== before;
      const shown = this.#viewer.camera;
      if (!isMoved && camera && shown && writeCamera(camera) !== writeCamera(shown)) {
        this.#camera = shown;
        notes.push(pageTexts.viewTooFar);
      }
      if (notes.length > 0) this.#toast.note(notes.join(" "));
    } catch (error) {
      if (error instanceof DOMException && error.name === "AbortError") return;
      this.#showError(error);
    }
  }

  get #urlCamera(): Camera | undefined {
    const { camera, projection } = this.#url;
    return camera && projection === "orthographic" ? { ...camera, projection } : camera;
  }

  /** The camera, or the one at which it will come to rest. */
  get #restingCamera(): Camera | undefined {
    return this.#motion.target ?? this.#camera ?? this.#viewer.camera ?? this.#urlCamera;
  }

  get #isDefaultCamera(): boolean {
    const camera = this.#restingCamera;
    if (!camera || this.#url.camera) return false;
    const defaults = [this.#firstCamera, this.#viewer.wholeView];
    return defaults.some((each) => each && isSameCamera(each, camera));
  }

  /** Called after the page opened the volume, or the viewer reopened it after a context loss. */
  #onOpened(info: StoreInfo): void {
    this.#info = info;
    this.#cost = null;
    this.#failures = 0;
    this.#problem = null;
    this.#rendererError = null;
    document.title = `${this.#title()} · Isosplat`;
    this.#render();
  }

  #title(): string {
    return this.#info?.metadata.title || this.#info?.metadata.name || this.#target.name;
  }

  /** For names of files. */
  #isovalues(): string {
    return this.#settings.surfaces.map((surface) => plainValue(surface.isovalue)).join("-");
  }

  /**
   * Handles an error of the viewer. For an open volume, its progress gives more details on faults
   * of the source.
   */
  #onViewerError(error: StreamError | RendererError): void {
    if (this.#viewer.info === null) {
      this.#showError(error, error instanceof StreamError && error.retrying);
    } else if (error instanceof RendererError) {
      this.#rendererError = error;
      this.#render();
    }
  }

  /** What the isovalue costs is found when the view rests: it takes time in large volumes. */
  #findCost(): void {
    const { surfaces, active } = this.#settings.state;
    const isovalue = surfaces[active]?.isovalue;
    if (isovalue === undefined || this.#cost?.isovalue === isovalue) return;
    const bytes = this.#viewer.bytesOf(isovalue);
    if (bytes === undefined) return;
    this.#cost = { isovalue, bytes };
    this.#render();
  }

  /** Publishes whether the picture or the address will still change by themselves. */
  #showBusy(): void {
    this.#canvas.ariaBusy = String(this.#viewer.isBusy || this.#address.isPending);
  }

  /** Removes messages about a view that is no longer shown. */
  #resetProgress(): void {
    this.#progress = null;
    this.#status.clear();
  }

  /** The volume cannot be opened. `isRetryScheduled`: another try is already scheduled. */
  #showError(error: unknown, isRetryScheduled = false): void {
    this.#resolveFirstContent();
    this.#settings.closed();
    this.#resetProgress();
    this.#problem = problemOf(error, this.#target.name);
    clearTimeout(this.#reopenTimer);
    const { retry } = faults[kindOf(error)];
    if (!isRetryScheduled && retry !== "never") {
      const wait = slowWait(this.#failures++);
      this.#reopenTimer = window.setTimeout(() => void this.#open({ again: true }), wait);
    }
    this.#render();
    if (error instanceof StreamError && error.kind === "not-found" && this.#url.volume) {
      fetchVolumes({ limit: 20 })
        .then(({ volumes }) => {
          this.#names = volumes.filter((volume) => !volume.error).map((volume) => volume.name);
          this.#render();
        })
        .catch(() => {}); // the message is shown without the list
    }
  }

  /** The fault that currently prevents a complete picture, while the volume is open. */
  get #currentFault(): (Problem & { isWaiting: boolean }) | null {
    const { name } = this.#target;
    if (this.#isContextLost) return { ...problemOfFault("context-lost", name), isWaiting: true };
    if (this.#rendererError) return { ...problemOf(this.#rendererError, name), isWaiting: false };
    const fault = this.#progress?.fault;
    if (!fault) return null;
    const isWaiting = faults[fault.kind].retry === "soon";
    return { ...problemOfFault(fault.kind, name, fault.message), isWaiting };
  }

  #retry(): void {
    // Restarts the renderer if it failed, and requests that wait for another try.
    if (this.#viewer.info === null || this.#rendererError) void this.#open();
    else this.#viewer.retry();
  }

  // ---- Actions of the controls ----

  readonly #actions: LayoutActions = {
    ...this.#settings.actions,
    retry: () => this.#retry(),
    reset: () => this.#reset(),
    fit: () => this.#fit(),
    toggleProjection: () => this.#toggleProjection(),
    openCapture: () => void this.#openCapture(),
    saveTransparent: () => void this.#saveScreenshot({ transparent: true }),
    saveSurface: () => void this.#saveSurface(),
    undo: () => this.#restore("undo"),
    redo: () => this.#restore("redo"),
    lookAlong: (view) => this.#lookAlong(view),
    savePicture: () => void this.#saveScreenshot(),
    copyLink: () => void this.#copyLink(),
    loadMeasure: () => void this.#loadMeasure(),
    loadSlices: () => void this.#loadSlices(),
    showClipHandles: (isShown) => void this.#showClipHandles(isShown),
    toggleSheet: () => this.#openSheet(!this.#isSheetOpen),
    help: showHelp,
    removeSurface: (index) => {
      this.#settings.actions.removeSurface(index);
      this.#renderNow();
      // The focused button was removed, or now belongs to another surface.
      const rows = this.root.querySelectorAll<HTMLElement>(".surface-value");
      rows[Math.min(index, rows.length - 1)]?.focus();
    },
  };

  readonly #keys: Readonly<Record<string, () => void>> = {
    "[": () => this.#settings.step(-1, "hundredth"),
    "]": () => this.#settings.step(1, "hundredth"),
    "{": () => this.#settings.step(-1, "step"),
    "}": () => this.#settings.step(1, "step"),
    "?": showHelp,
    c: () => void this.#copyLink(),
    s: () => void this.#saveScreenshot(),
    S: () => void this.#openCapture(),
    t: toggleTheme,
    f: () => this.#togglePanel(),
    r: () => this.#reset(),
    v: () => this.#fit(),
    p: () => this.#toggleProjection(),
    m: () => void this.#beginMeasuring(),
    ...Object.fromEntries(axisViews.map((view, i) => [String(i + 1), () => this.#lookAlong(view)])),
    Escape: () => {
      this.#measure?.tool.choose(null);
      this.#openSheet(false);
    },
  };

  #reset(): void {
    const whole = this.#viewer.wholeView;
    if (whole) this.#motion.to(whole);
  }

  #fit(): void {
    const { camera, wholeView } = this.#viewer;
    if (!camera || !wholeView) return;
    const { target, distance } = wholeView;
    this.#motion.to({ ...camera, target, distance });
  }

  /** Measures distances, or ends measuring. */
  async #beginMeasuring(): Promise<void> {
    await this.#loadMeasure();
    const tool = this.#measure?.tool;
    tool?.choose(tool.kind ?? "distance");
  }

  #restore(step: "undo" | "redo"): void {
    this.#address.write(); // what has not come to rest is a view as well
    const view = this.#history[step]();
    if (!view) return;
    this.#settings.restore(view);
    if (view.camera) this.#motion.to(view.camera);
  }

  #toggleProjection(): void {
    const isOrthographic = this.#viewer.camera?.projection === "orthographic";
    this.#viewer.setProjection(isOrthographic ? "perspective" : "orthographic");
    this.#render();
  }

  #lookAlong(view: AxisView): void {
    const { camera } = this.#viewer;
    if (camera) this.#motion.to(cameraAlong(camera, view));
  }

  /** What lies above the picture is loaded after the first surface. */
  async loadOverlay(): Promise<void> {
    const { Overlay } = await import("../../overlay/overlay.ts");
    this.#overlay = new Overlay(this.#viewer, (view) => this.#lookAlong(view));
    this.#render();
    if (this.#url.measures || hasKeptSession()) await this.#loadMeasure();
  }

  /** Loads the handles at their first use. */
  async #showClipHandles(isShown: boolean): Promise<void> {
    this.#isClipBoxShown = isShown;
    this.#render();
    if (!isShown || this.#clipHandles) return;
    try {
      const { ClipHandles } = await import("../../overlay/clip_handles.ts");
      this.#clipHandles ??= new ClipHandles(this.#viewer, this.#settings.actions.changeClip);
      this.#render();
    } catch {
      this.#toast.note(pageTexts.noHandles);
    }
  }

  async #loadSlices(): Promise<void> {
    if (this.#slicesSection) return;
    try {
      this.#slicesSection = (await import("../panel/slices_section.ts")).slicesSection;
      this.#render();
    } catch {
      this.#toast.note(pageTexts.noSection);
    }
  }

  /** Measurements are loaded when they are first used, or if the address has some. */
  #loadMeasure(): Promise<void> {
    this.#loadingMeasure ??= import("../measure/measure.ts").then(
      ({ Measure }) => {
        const host = {
          changed: () => {
            this.#address.changed();
            this.#render();
          },
          render: () => this.#render(),
          renderNow: () => this.#renderNow(),
          note: (text: string) => this.#toast.note(text),
          done: (text: string) => this.#toast.done(text),
          save: (name: string, type: string, text: string) =>
            saveFile(this.#fileName(name), new Blob([text], { type })),
          view: () => {
            const view = this.#address.view;
            return view ? writeUrl(addressOf({ ...view, measures: [] })) : location.search;
          },
        };
        this.#measure = new Measure(this.#viewer, host, this.#url.measures ?? [], this.#search);
        this.#render();
      },
      () => {
        this.#loadingMeasure = null;
        this.#toast.note(pageTexts.noMeasuring);
      },
    );
    return this.#loadingMeasure;
  }

  /** The volume, once it is open. */
  get info(): StoreInfo | null {
    return this.#info;
  }

  /** Adds a button to the bar. */
  set tools(element: HTMLElement) {
    this.#tools = element;
    this.#render();
  }

  /** Ends what the page has begun; its elements are not removed. */
  close(): void {
    this.#info = null; // the address is no longer written
    this.#clipHandles?.stop();
    clearTimeout(this.#reopenTimer);
    this.#listeners.abort();
    this.#viewer.dispose();
  }

  #openSheet(isOpen: boolean): void {
    if (isOpen === this.#isSheetOpen) return;
    this.#isSheetOpen = isOpen;
    this.#renderNow();
    // The focused element may now be hidden.
    if (!isOpen) this.root.querySelector<HTMLElement>(".sheet-handle")?.focus();
  }

  #togglePanel(): void {
    this.#isPanelHidden = !this.#isPanelHidden;
    this.#render();
  }

  async #copyLink(): Promise<void> {
    this.#address.write();
    try {
      await navigator.clipboard.writeText(location.href);
      this.#toast.done(pageTexts.linkCopied);
    } catch {
      this.#toast.note(pageTexts.noClipboard);
    }
  }

  async #saveScreenshot(options: { transparent?: boolean } = {}): Promise<void> {
    try {
      const picture = await this.#viewer.screenshot(options);
      saveFile(this.#fileName(`${this.#isovalues()}.png`), picture);
      this.#toast.done(pageTexts.pictureSaved);
    } catch (error) {
      this.#toast.note(error instanceof Error ? error.message : pageTexts.noPicture);
    }
  }

  async #saveSurface(): Promise<void> {
    const { surfaces, active, clip } = this.#settings.state;
    const { isovalue } = surfaces[active] ?? {};
    const access = this.#viewer.storeAccess;
    if (isovalue === undefined || !access) return;
    try {
      const { openSurfaceDialog } = await import("../capture/surface_dialog.ts");
      openSurfaceDialog(access, isovalue, clip, (ending, file) =>
        saveFile(this.#fileName(`${isovalue}.${ending}`), file),
      );
    } catch {
      this.#toast.note(pageTexts.noSaving);
    }
  }

  async #openCapture(): Promise<void> {
    try {
      this.#capture ??= import("../capture/capture_dialog.ts").then(
        ({ CaptureDialog }) =>
          new CaptureDialog({
            viewer: this.#viewer,
            activeSurface: () => this.#settings.state.active,
            save: (ending, content) =>
              saveFile(this.#fileName(`${this.#isovalues()}-${ending}`), content),
          }),
      );
      await (await this.#capture).open();
    } catch {
      this.#capture = null;
      this.#toast.note(pageTexts.noDialog);
    }
  }

  #fileName(ending: string): string {
    return `${this.#title().replace(/[^\w.-]+/g, "-")}-${ending}`;
  }

  #keepThumbnail(): void {
    const id = this.#info?.contentId;
    if (!id || this.#keptThumbnail === id || !this.#hasPicture || this.#target.provisional) return;
    this.#keptThumbnail = id;
    keepThumbnailWhenIdle(id, () => this.#viewer.screenshot({ smooth: false }));
  }

  // ---- Layout ----

  #render(): void {
    if (this.#renderHandle === 0) {
      this.#renderHandle = requestAnimationFrame(() => this.#renderNow());
    }
  }

  #renderNow(): void {
    cancelAnimationFrame(this.#renderHandle);
    this.#renderHandle = 0;
    const info = this.#info;
    const settings = this.#settings.state;
    const isovalues = listed(settings.surfaces.map(({ isovalue }) => formatValue(isovalue)));
    this.#canvas.setAttribute("aria-label", pageTexts.picture(this.#title(), isovalues));
    const fault = this.#problem ? null : this.#currentFault;
    const banner: Banner | null = fault && {
      ...fault,
      text: `${fault.title}. ${fault.text}`,
    };
    const { state } = this.#progress ?? {};
    const isSettled = state === "complete" || state === "incomplete" || state === "offline";
    const active = settings.surfaces[settings.active]?.isovalue;
    const bytes = this.#cost?.isovalue === active ? this.#cost?.bytes : undefined;
    const layout: LayoutState = {
      title: this.#title(),
      provisional: this.#target.provisional,
      tools: this.#tools,
      panel: info
        ? {
            info,
            projection: this.#viewer.camera?.projection,
            canUndo: this.#history.canUndo,
            canRedo: this.#history.canRedo,
            histogram: this.#histogram.element,
            bytes,
            ...settings,
          }
        : null,
      background: settings.look.background,
      // If there is no picture, the error takes its place.
      problem: this.#problem ?? (this.#hasPicture ? null : fault),
      names: this.#names,
      legend: this.#viewer.legend,
      banner: this.#hasPicture ? banner : null,
      toast: this.#toast.message,
      isOpening: !this.#hasPicture && !isSettled,
      isSheetOpen: this.#isSheetOpen,
      isPanelHidden: this.#isPanelHidden,
      canvas: this.#canvas,
      overlay: this.#overlay?.element ?? null,
      clipHandles:
        this.#isClipBoxShown && !this.#isPanelHidden ? (this.#clipHandles?.element ?? null) : null,
      measure:
        this.#measure && info
          ? { element: this.#measure.element, section: this.#measure.section(info) }
          : null,
      slicesSection: this.#slicesSection,
      status: this.#status.element,
    };
    this.#overlay?.show(settings.show);
    this.#clipHandles?.request();
    render(volumeLayout(layout, this.#actions), this.root);
    if (info) {
      const { scale, isLogarithmic } = settings;
      const { suggestions, marks } = this.#settings;
      const { histogram, active_cells: activeCells } = info.metadata;
      this.#histogram.show({ scale, suggestions, histogram, activeCells, isLogarithmic }, marks);
    }
  }
}

function isSameCamera(a: Camera, b: Camera): boolean {
  const isOrthographic = ({ projection }: Camera) => projection === "orthographic";
  return writeCamera(a) === writeCamera(b) && isOrthographic(a) === isOrthographic(b);
}

/** A session may belong to the address: see open_session.ts. */
function hasKeptSession(): boolean {
  try {
    return sessionStorage.getItem(keptSessionKey) !== null;
  } catch {
    return false; // the browser keeps nothing
  }
}

function saveFile(name: string, content: Blob): void {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(content);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

async function showHelp(): Promise<void> {
  (await import("../shell/help.ts")).showHelp();
}
