import type { StoreInfo } from "../../core/types.ts";
import { type Progress, StreamError } from "../../stream/types.ts";
import { pageTexts } from "../../texts/page.ts";
import { RendererError } from "../../viewer/renderer_error.ts";
import { AddressBar, type AddressState, awaitsRange } from "../address/page_address.ts";
import type { Target } from "../address/target.ts";
import { openedQuery, readUrl } from "../address/url_state.ts";
import { ViewHistory } from "../address/view_history.ts";
import { DisplaySettings } from "../panel/display_settings.ts";
import { SurfaceSettings } from "../panel/surface_settings.ts";
import { onTheme } from "../shell/theme.ts";
import { Toast } from "../shell/toast.ts";
import { copyLink, shareLink } from "./copy_link.ts";
import { EnteredSpacing } from "./entered_spacing.ts";
import { LayersPart } from "./layers_part.ts";
import { LoadedParts } from "./loaded_parts.ts";
import { openTargetIn } from "./opening.ts";
import { PageCamera } from "./page_camera.ts";
import { PageFiles } from "./page_files.ts";
import { keyActions, listenToKeys } from "./page_keys.ts";
import { PageLayout } from "./page_layout.ts";
import { StatusLine } from "./status_line.ts";
import { takeView } from "./view.ts";
import { VolumeFaults } from "./volume_faults.ts";
import type { LayoutActions } from "./volume_layout.ts";

/**
 * The page of one volume: opens it, shows its progress and lays out the page. Owns the viewer and
 * the address.
 */
export class VolumePage {
  readonly root: HTMLElement;
  #target: Target;
  readonly #view = takeView(() => this.#camera.reset());
  readonly #canvas = this.#view.canvas;
  readonly #viewer = this.#view.viewer;
  readonly #status = new StatusLine(this.#viewer);
  readonly #search = openedQuery();
  readonly #url = readUrl(this.#search);
  readonly #toast = new Toast(() => this.#layout.request());
  readonly #listeners = new AbortController();
  readonly #faults = new VolumeFaults(
    () => void this.#open({ again: true }),
    () => this.#layout.request(),
  );
  readonly #camera = new PageCamera(this.#viewer, this.#url, () => this.#address.changed());
  readonly #surfaces = new SurfaceSettings(this.#viewer, this.#url, (only) => this.#changed(only));
  readonly #settings = new DisplaySettings(this.#viewer, this.#url, () => this.#changed());
  /** The layers of the picture. */
  readonly layers = new LayersPart(
    {
      viewer: this.#viewer,
      surfaces: this.#surfaces,
      title: () => this.#title(),
      changed: () => this.#changed(),
      render: () => this.#layout.request(),
      chosen: () => this.#viewer.isBusy || this.#layout.rests(),
      saveScene: () => void this.#files.saveScene(this.#settings.state, this.#parts.measurements()),
      note: (text) => this.#toast.note(text),
    },
    this.#url,
    this.#search,
  );
  readonly #files = new PageFiles(this.#viewer, this.#surfaces, this.layers, this.#toast, {
    title: () => this.#title(),
    measurements: () => this.#parts.measure?.labelled ?? [],
  });
  readonly #parts = new LoadedParts(this.#viewer, this.#url, this.#search, {
    chosen: () => this.layers.chosen ?? this.#viewer,
    title: () => this.#title(),
    titleOfHit: (layer) => this.layers.titleOfHit(layer),
    lookAlong: (view) => this.#camera.lookAlong(view),
    changeClip: (clip) => this.#settings.actions.changeClip(() => clip),
    changed: () => this.#changed(),
    render: () => this.#layout.request(),
    renderNow: () => this.#layout.renderNow(),
    note: (text) => this.#toast.note(text),
    names: (text) => this.#toast.names(text),
    done: (text) => this.#toast.done(text),
    save: (name, type, text) => this.#files.save(name, new Blob([text], { type })),
    view: () => this.#address.picture ?? location.search,
  });
  readonly #history = new ViewHistory<AddressState>();
  readonly #address = new AddressBar(
    () => this.#addressState(),
    () => this.#showBusy(),
    (settings, view, isWhole) => {
      // The range of a field that has just been chosen follows from its values.
      if (!awaitsRange(view)) this.#history.rested(settings, view);
      this.#parts.rested(isWhole);
      this.#layout.request();
    },
  );

  readonly #spacing = new EnteredSpacing(this.#viewer, this.#url, this.#parts, {
    rest: () => this.#address.write(),
    reopen: () => this.#open({ keepsView: true }),
    camera: this.#camera,
    failed: () => this.#restorePresent(),
    noDialog: () => this.#toast.note(pageTexts.noDialog),
    changed: () => this.#changed(),
  });

  #info: StoreInfo | null = null;
  #sceneTitle = "";
  #hasPicture = false;
  readonly #layout: PageLayout;

  /** Resolves when something is visible: a surface or an error message. */
  readonly firstContent: Promise<void>;
  #resolveFirstContent = () => {};

  constructor(root: HTMLElement, target: Target) {
    this.root = root;
    this.#target = target;
    this.#layout = this.#newLayout(root);
    this.#listen();
    this.firstContent = new Promise((resolve) => {
      this.#resolveFirstContent = resolve;
    });
    // Starts requests and workers before the page is laid out.
    void this.#open();
    this.#layout.renderNow();
  }

  #listen(): void {
    const viewer = this.#viewer;
    viewer.on("progress", (progress) => this.#onProgress(progress));
    viewer.on("frame", (frame) => {
      this.#status.frame(frame);
      this.#faults.drawn();
      if (this.#hasPicture || frame.samplesDrawn === 0) return;
      this.#hasPicture = true;
      this.#layout.request();
      // The browser shows it in the frame after the next one.
      requestAnimationFrame(() => requestAnimationFrame(this.#resolveFirstContent));
    });
    viewer.on("opened", (info) => this.#onOpened(info));
    viewer.on("replaced", (info) => {
      if (!this.#surfaces.subject) this.#surfaces.opened(info);
      this.#toast.note(pageTexts.replaced);
    });
    viewer.on("busy", (isBusy) => {
      if (!isBusy) this.#status.rests();
      this.#layout.busyChanged(isBusy);
      this.#showBusy();
    });
    viewer.on("error", (error) => this.#onViewerError(error));
    viewer.on("context", (state) => {
      this.#faults.context(state);
      // The complete picture no longer exists.
      this.#resetProgress();
      this.#layout.request();
    });
    onTheme(() => {
      this.#settings.themeChanged();
      this.#layout.themeChanged();
    });
    this.#canvas.addEventListener("dblclick", (event) => {
      if (!this.#parts.measure?.tool.kind) this.#camera.centre(event);
    });
    const keys = keyActions(this.#surfaces, this.#parts, this.#layout, this.#actions);
    const restore = (step: "undo" | "redo") => this.#restore(step);
    listenToKeys(this.#canvas, viewer, keys, restore, this.#listeners.signal);
  }

  /**
   * Shows another store of the same volume with the present view. Camera, settings and steps of
   * undo stay, and so does the picture until the other store has one. An isovalue that the page has
   * chosen is chosen again. `src`: the store's address; by default unchanged.
   */
  async replace(target: Target, src = this.#url.src): Promise<void> {
    this.#address.write(); // a view that has not come to rest is a step of undo as well
    this.#history.replacePresent();
    this.#target = target;
    if (src !== undefined) this.#url.src = src;
    await this.#open({ keepsView: true });
  }

  /** `again`: the message of the last attempt stays until this one succeeds. Resolves to false if it fails. */
  async #open({ again = false, keepsView = false } = {}): Promise<boolean> {
    this.#faults.opening({ again, keepsView });
    this.#resetProgress();
    if (!keepsView) {
      this.#surfaces.closed();
      this.#hasPicture = false;
    }
    document.title = `${this.#target.name} · Isosplat`;
    this.layers.closing();
    this.#layout.request();
    try {
      const surfaces = this.#surfaces.hasSuggested ? [] : this.#surfaces.surfaces;
      const before = this.#camera.moved;
      const camera = this.#camera.toOpen(keepsView);
      const view = { surfaces, camera };
      const opened = await openTargetIn(this.#viewer, this.#target, this.#url, view, again);
      this.#sceneTitle = opened.title;
      if (this.#info !== opened.info || opened.title) this.#onOpened(opened.info);
      this.#settings.opened(opened.scene);
      this.#parts.opened(opened.scene);
      const notes = [...this.#surfaces.opened(opened.info, opened.hasSurfaces), ...opened.notes];
      void this.layers.opened(opened.scene);
      const isElsewhere = this.#camera.opened(camera, before, keepsView, "scene" in this.#target);
      if (keepsView) return true;
      notes.unshift(...(this.#url.notes ?? []));
      if (isElsewhere) notes.push(pageTexts.viewTooFar);
      if (notes.length > 0) this.#toast.note(notes.join(" "));
    } catch (error) {
      if (!(error instanceof DOMException && error.name === "AbortError")) {
        this.#showError(error);
        return false;
      }
    }
    return true;
  }

  /** A setting has changed: updates the address and the layout. */
  #changed(isIsovalueOnly = false): void {
    this.#address.changed();
    this.#layout.request(isIsovalueOnly);
  }

  /** The state to write to the address; null while no volume can be opened, or its spacing is being changed. */
  #addressState(): AddressState | null {
    if (!this.#info || this.#faults.problem || this.#spacing.isChanging) return null;
    return {
      volume: this.#url.volume,
      scene: this.#url.scene,
      src: this.#url.src,
      ...this.#spacing.stateOf(this.#info),
      ...this.#settings.state,
      surfaces: this.#surfaces.first,
      camera: this.#camera.resting,
      isDefaultCamera: this.#camera.isDefault,
      time: this.#parts.time.value,
      measures: this.#parts.measures,
      measurements: this.#parts.measure?.tool.measurements ?? null,
      layers: this.layers.view,
    };
  }

  #onProgress(progress: Progress): void {
    // Such errors concern chunks that were lost with the context.
    if (this.#faults.isContextLost) return;
    this.#status.progress(progress);
    if (this.#faults.progress(progress)) this.#layout.request();
    const isFinal = progress.state === "complete" || progress.state === "limited";
    if (isFinal && this.#info && this.#hasPicture && !this.#target.provisional) {
      this.#files.keepThumbnail(this.#info);
    }
  }

  /** Called after the page opened the volume, or the viewer reopened it after a context loss. */
  #onOpened(info: StoreInfo): void {
    this.#info = info;
    this.#faults.opened();
    document.title = `${this.#title()} · Isosplat`;
    this.#layout.opened();
  }

  #title(): string {
    return (
      this.#sceneTitle ||
      this.#info?.metadata.title ||
      this.#info?.metadata.name ||
      this.#target.name
    );
  }

  /** For an open volume, its progress gives more details on faults of the source. */
  #onViewerError(error: StreamError | RendererError): void {
    if (this.#viewer.info === null) {
      this.#showError(error, error instanceof StreamError && error.retrying);
    } else if (error instanceof RendererError) {
      this.#faults.rendererFailed(error);
    }
  }

  /** Publishes whether the picture or the address will still change without further calls. */
  #showBusy(): void {
    this.#canvas.ariaBusy = String(this.#viewer.isBusy || this.#address.isPending);
  }

  /** Removes messages about a view that is no longer shown. */
  #resetProgress(): void {
    this.#faults.progress(null);
    this.#status.clear();
  }

  /** The volume cannot be opened. `isRetryScheduled`: another attempt is already scheduled. */
  #showError(error: unknown, isRetryScheduled = false): void {
    this.#resolveFirstContent();
    this.#surfaces.closed();
    this.#resetProgress();
    const listed = this.#url.volume ? "volume" : this.#url.scene ? "scene" : null;
    this.#faults.notOpened(error, this.#target.name, isRetryScheduled, listed);
  }

  #retry(): void {
    // Restarts the renderer if it failed, and requests that wait for another attempt.
    if (this.#viewer.info === null || this.#faults.hasRendererError) void this.#open();
    else this.#viewer.retry();
  }

  // ---- Actions of the controls ----

  readonly #actions: LayoutActions = {
    ...this.#surfaces.actions,
    ...this.#settings.actions,
    retry: () => this.#retry(),
    reset: () => this.#camera.reset(),
    fit: () => this.#camera.fit(),
    toggleProjection: () => {
      this.#camera.toggleProjection();
      this.#layout.request();
    },
    openCapture: () => void this.#files.openCapture(),
    saveTransparent: () => void this.#files.saveScreenshot({ transparent: true }),
    saveSurface: () => void this.#files.saveSurface(() => void this.#spacing.enter()),
    undo: () => this.#restore("undo"),
    redo: () => this.#restore("redo"),
    lookAlong: (view) => this.#camera.lookAlong(view),
    savePicture: () => void this.#files.saveScreenshot(),
    copyLink: () => void copyLink(this.#address, this.#toast),
    shareLink: () => void shareLink(this.#address, this.#toast, this.#title()),
    loadMeasure: () => void this.#parts.loadMeasure(),
    loadLayers: () => void this.layers.load(),
    showChosen: () => this.layers.showChosen(),
    loadSlices: () => void this.#parts.loadSlices(),
    showClipHandles: (isShown) => void this.#parts.showClipHandles(isShown),
    toggleSheet: () => this.#layout.toggleSheet(),
    enterSpacing: () => void this.#spacing.enter(),
    help: () =>
      void import("../shell/help.ts").then(
        ({ showHelp }) => showHelp(),
        () => this.#toast.note(pageTexts.noDialog),
      ),
    removeSurface: (index) => {
      this.#surfaces.actions.removeSurface(index);
      this.#layout.focusSurface(index);
    },
  };

  #restore(step: "undo" | "redo"): void {
    if (this.#spacing.postpones(() => this.#restore(step)) || this.#faults.problem) return;
    this.#address.write(); // a view that has not come to rest is a step as well
    const view = this.#history[step]();
    if (!view) return;
    this.#apply(view);
    const back = () => this.#history[step === "undo" ? "redo" : "undo"]();
    if (view.camera && !this.#spacing.restore(view, back)) this.#camera.to(view.camera);
  }

  /** The volume could not be opened with another spacing. */
  #restorePresent(): void {
    const view = this.#history.present;
    if (view) this.#apply(view);
    if (view?.camera) this.#viewer.setCamera(view.camera);
    this.#toast.note(pageTexts.spacingUnchanged);
  }

  /** Shows an earlier view, without its camera and its spacing. */
  #apply(view: AddressState): void {
    this.#settings.restore(view);
    this.#surfaces.restore(view.surfaces);
    this.layers.restore(view.layers);
    this.#parts.time.restore(view.time);
    this.#parts.measure?.restore(view.measures, view.measurements);
  }

  /** Loads the overlays above the picture, after the first surface. */
  loadOverlay(): Promise<void> {
    return this.#parts.loadOverlay();
  }

  /** The volume, once it is open. */
  get info(): StoreInfo | null {
    return this.#info;
  }

  /** The query of the present view, for another copy of the volume. */
  get view(): string {
    return this.#address.settings;
  }

  /** Adds a button to the bar. */
  set tools(element: HTMLElement) {
    this.#layout.tools = element;
  }

  /** Ends all work of the page; its elements are not removed. */
  close(): void {
    this.#info = null; // the address is no longer written
    this.#parts.clipHandles?.stop();
    this.#faults.close();
    this.#surfaces.closed();
    this.#layout.close();
    this.#listeners.abort();
    this.#viewer.dispose();
  }

  #newLayout(root: HTMLElement): PageLayout {
    const page = this;
    return new PageLayout(root, {
      viewer: this.#viewer,
      surfaces: this.#surfaces,
      settings: this.#settings,
      faults: this.#faults,
      parts: this.#parts,
      layers: this.layers,
      status: this.#status,
      toast: this.#toast,
      history: this.#history,
      actions: this.#actions,
      get target() {
        return page.#target;
      },
      get info() {
        return page.#info;
      },
      get hasPicture() {
        return page.#hasPicture;
      },
      get title() {
        return page.#title();
      },
    });
  }
}
