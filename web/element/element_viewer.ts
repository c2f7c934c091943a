import type { StoreInfo } from "../core/types.ts";
import type { SceneSource } from "../scene/scene_source.ts";
import { faults, slowWait } from "../stream/faults.ts";
import type { Source } from "../stream/source.ts";
import { type Progress, StreamError } from "../stream/types.ts";
import { withoutOptions } from "../texts/without_options.ts";
import { RendererError } from "../viewer/renderer_error.ts";
import { compiledRenderer } from "../viewer/renderer_program.ts";
import { Viewer } from "../viewer/viewer.ts";
import type { ContextUser } from "./context_pool.ts";
import { ElementLayers } from "./element_layers.ts";
import { type Content, openContent } from "./element_opening.ts";
import type { ElementParts } from "./element_parts.ts";
import type { ContentKind, ElementView } from "./element_view.ts";
import { contexts, sharedWorkers } from "./page_resources.ts";
import { stillOf } from "./picture_area.ts";

/** The time that the renderer may take to load before the element reports it. */
const startLimitMs = 4000;

/**
 * The viewer of an element. It exists while the pool grants the element a WebGL context. Opens the source or the
 * scene with the element's view, adds the child elements, retries after faults, and reports events. When it loses
 * its context, it leaves a still picture.
 */
export class ElementViewer {
  readonly #element: HTMLElement;
  readonly #root: ShadowRoot;
  readonly #parts: ElementParts;
  readonly #view: ElementView;
  readonly #user = this.#asContextUser();
  readonly #sight = new IntersectionObserver((entries) => this.#seen(entries), {
    rootMargin: "100px",
  });
  #viewer: Viewer | null = null;
  #sampleBudget = 0;
  #source: Source | null = null;
  #scene: (() => Promise<SceneSource>) | null = null;
  readonly #layers: ElementLayers;
  #opening: AbortController | null = null;
  #reopenTimer = 0;
  #failures = 0;
  #isVisible = false;
  #hasPicture = false;
  #wasComplete = false;
  /** Whether the content of the last `#open()` is open and has the element's view. */
  #isOpen = false;
  #hasFailed = false;
  /** The layers of the scene that cannot be shown. */
  #missing: readonly Error[] = [];
  #info: StoreInfo | null = null;
  #progress: Progress | null = null;

  constructor(element: HTMLElement, root: ShadowRoot, parts: ElementParts, view: ElementView) {
    this.#element = element;
    this.#root = root;
    this.#parts = parts;
    this.#view = view;
    this.#layers = new ElementLayers(element, {
      added: (viewer) => this.#onLayerAdded(viewer),
      fault: (error) => this.fault(error),
      wake: () => this.#layersChanged(),
    });
  }

  /** Null while the element has no WebGL context. */
  get viewer(): Viewer | null {
    return this.#viewer;
  }

  get source(): Source | null {
    return this.#source;
  }

  /** The open volume; null before the first. */
  get info(): StoreInfo | null {
    return this.#info;
  }

  /** The last progress; null before the first. */
  get progress(): Progress | null {
    return this.#progress;
  }

  /** Whether the viewer has opened a volume that does not have the element's view yet. */
  get isOpening(): boolean {
    const viewer = this.#viewer;
    return viewer !== null && !this.#isOpen && (viewer.info !== null || viewer.layers.length > 0);
  }

  /** Sets another source, or none. */
  setSource(source: Source | null): void {
    const isFirst = this.#isEmpty;
    this.#source = source;
    // A scene is shown instead.
    if (!this.#scene) this.#contentChanged(isFirst);
  }

  /** Sets another scene, or none. It is shown instead of the source. */
  setScene(scene: (() => Promise<SceneSource>) | null): void {
    const isFirst = this.#isEmpty;
    this.#scene = scene;
    this.#contentChanged(isFirst);
  }

  get #content(): Content {
    if (this.#scene) return { scene: this.#scene };
    return this.#source && { source: this.#source };
  }

  get #kind(): ContentKind {
    if (this.#scene) return "scene";
    return this.#source ? "store" : "layers";
  }

  get #isEmpty(): boolean {
    return !this.#content && !this.#layers.hasAny;
  }

  #contentChanged(isFirst: boolean): void {
    this.#info = null;
    if (!isFirst) {
      this.#hasPicture = false;
      this.#parts.showPoster();
      this.#view.reset();
    }
    if (this.#viewer) void this.#open();
    this.wake();
  }

  /** Child elements were added, removed or changed. */
  #layersChanged(): void {
    // If nothing is open, the first child elements open the picture. Otherwise the viewer adds them to it.
    if (this.#viewer && !this.#opening && this.#layers.hasAny) void this.#open();
    this.wake();
  }

  /** The element was added to a document. It gets a viewer once it is visible. */
  attach(): void {
    this.#layers.attach();
    this.#sight.observe(this.#element);
  }

  /** The element was removed from its document. */
  detach(): void {
    this.#sight.disconnect();
    this.#isVisible = false;
    this.#close();
    this.#layers.detach();
    this.#parts.clear();
    this.#hasPicture = false;
    contexts.release(this.#user);
  }

  /** Requests a context, or reports the use of the present one. isUrgent: a visitor is about to use the element. */
  wake(isUrgent = false): void {
    if (this.#isVisible && !this.#isEmpty) contexts.request(this.#user, isUrgent);
  }

  /** Retries at once everything that waits for its next attempt. */
  retry(): void {
    const isShown = this.#info !== null && !this.#hasFailed && this.#missing.length === 0;
    if (isShown || !this.#viewer) this.#viewer?.retry();
    else void this.#open();
    this.#layers.retry();
  }

  /** Shows a fault, and reports it. */
  fault(error: StreamError | RendererError): void {
    this.#parts.showMessage(wordsOf(error));
    this.#report("fault", error);
  }

  #report(name: string, detail: unknown): void {
    this.#element.dispatchEvent(new CustomEvent(name, { detail }));
  }

  // ---- The context ----

  #asContextUser(): ContextUser {
    const isVisible = () => this.#isVisible;
    const isBusy = () => this.#viewer?.isBusy ?? false;
    const isFocused = () => this.#element.matches(":focus-within");
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
          this.#parts.overlays.attach(this.#viewer);
        } catch (error) {
          this.fault(faultOf(error));
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

  #seen(entries: readonly IntersectionObserverEntry[]): void {
    this.#isVisible = entries.at(-1)?.isIntersecting ?? false;
    if (this.#viewer) contexts.changed();
    else if (this.#isVisible) this.wake();
    else contexts.release(this.#user);
  }

  #newViewer(): Viewer {
    const { picture } = this.#parts;
    const canvas = picture.addCanvas(this.#root.activeElement === picture.element);
    this.#hasPicture = false;
    const viewer = new Viewer(canvas, {
      decoder: sharedWorkers(),
      sampleBudget: this.#sampleBudget,
    });
    this.#view.applyTo(viewer);
    viewer.on("progress", (progress) => this.#onProgress(progress));
    viewer.on("frame", ({ samplesDrawn }) => {
      if (samplesDrawn === 0) return;
      this.#hasPicture = true;
      this.#parts.showCanvas();
    });
    viewer.on("camera", (camera) => {
      contexts.request(this.#user);
      this.#view.moved(camera);
    });
    viewer.on("opened", (info) => this.#onOpened(viewer, info));
    viewer.on("busy", () => contexts.changed());
    viewer.on("error", (error) => this.fault(error));
    const follow = () => this.#isOpen && this.#view.followSurfaces(viewer);
    viewer.on("layerchange", ({ property }) => property === "surfaces" && follow());
    viewer.on("layerremove", follow);
    this.#layers.listen(viewer);
    return viewer;
  }

  async #suspend(): Promise<void> {
    const { picture } = this.#parts;
    // Null if nothing has been drawn in this context: an older picture stays.
    const still = this.#viewer && this.#hasPicture ? await stillOf(this.#viewer) : null;
    // The element may have received the focus while the picture was being made.
    const { activeElement } = this.#root;
    const hadFocus = activeElement !== null && activeElement === this.#viewer?.canvas;
    this.#close();
    if (hadFocus) picture.element.focus({ preventScroll: true });
    if (!still) return;
    if (this.#element.isConnected && this.#hasPicture) picture.setStill(still);
    else URL.revokeObjectURL(still.src);
  }

  /** Ends all running work, and frees the context. */
  #close(): void {
    clearTimeout(this.#reopenTimer);
    this.#opening?.abort();
    this.#opening = null;
    this.#isOpen = false;
    this.#layers.hide();
    const viewer = this.#viewer;
    this.#viewer = null;
    if (!viewer) return;
    this.#parts.overlays.attach(null);
    viewer.dispose();
    const { canvas } = viewer;
    // The browser would free the context only when it collects the canvas as garbage.
    canvas.getContext("webgl2")?.getExtension("WEBGL_lose_context")?.loseContext();
    canvas.remove();
    this.#parts.picture.setFocusable(true);
  }

  // ---- The content ----

  async #open(): Promise<void> {
    const viewer = this.#viewer;
    clearTimeout(this.#reopenTimer);
    this.#opening?.abort();
    this.#opening = null;
    this.#wasComplete = false;
    this.#isOpen = false;
    this.#hasFailed = false;
    this.#missing = [];
    this.#layers.hide();
    if (!viewer) return;
    if (this.#isEmpty) {
      viewer.close();
      return;
    }
    const opening = new AbortController();
    this.#opening = opening;
    const { signal } = opening;
    this.#reportLateRenderer(signal);
    let hasCamera = this.#view.camera !== null;
    try {
      const opened = await openContent(viewer, this.#content, this.#view, signal);
      if (signal.aborted) return;
      const { info, missing } = opened;
      hasCamera ||= opened.hasCamera;
      this.#missing = missing;
      if (this.#scene) this.#onOpened(viewer, info);
      for (const error of missing) this.fault(faultOf(error));
    } catch (error) {
      if (signal.aborted) return;
      this.#onFailed(faultOf(error));
    }
    await this.#layers.show(viewer);
    // The first view shows all layers.
    if (!signal.aborted && !hasCamera && this.#layers.hasAny) this.#view.showWhole(viewer);
  }

  #onFailed(fault: StreamError | RendererError): void {
    this.#hasFailed = true;
    this.fault(fault);
    if (faults[fault.kind].retry === "never") return;
    const wait = slowWait(this.#failures++);
    this.#reopenTimer = window.setTimeout(() => void this.#reopen(), wait);
  }

  /** Opens content that could not be opened. The child elements stay in the picture until this succeeds. */
  async #reopen(): Promise<void> {
    const { signal } = this.#opening ?? {};
    const source = this.#scene ? null : this.#source;
    if (source && signal && this.#layers.hasAny) {
      try {
        await source.header(signal);
      } catch (error) {
        if (!signal.aborted) this.#onFailed(faultOf(error));
        return;
      }
    }
    void this.#open();
  }

  /** Reports a renderer that arrives late: a request that is never answered causes no error. */
  #reportLateRenderer(signal: AbortSignal): void {
    const timer = setTimeout(() => {
      if (signal.aborted) return;
      const text = `the renderer has not arrived for ${startLimitMs / 1000} s; still waiting for it`;
      this.fault(new RendererError(text, "unreachable"));
    }, startLimitMs);
    const end = () => clearTimeout(timer);
    compiledRenderer().then(end, end);
  }

  /** info: null if all layers are hidden. */
  #onOpened(viewer: Viewer, info: StoreInfo | null): void {
    this.#info = info;
    this.#failures = 0;
    this.#settleMessage();
    if (info) this.#parts.controls.opened(info);
    this.#view.opened(viewer, this.#hasFailed ? "layers" : this.#kind);
    this.#isOpen = true;
    this.#parts.controls.show(this.#view.isovalues[0]);
    if (info) this.#report("opened", info);
  }

  /** The first child element opens a picture that has no other content. */
  #onLayerAdded(viewer: Viewer): void {
    const hasContent = this.#content !== null && !this.#hasFailed;
    if (!this.#isOpen && !hasContent && viewer.info) this.#onOpened(viewer, viewer.info);
  }

  /** Shows why a part of the picture is missing, if one is. */
  #settleMessage(): void {
    const error = this.#missing[0] ?? this.#layers.presentFault;
    if (error) this.#parts.showMessage(wordsOf(faultOf(error)));
    else if (!this.#hasFailed) this.#parts.hideMessage();
  }

  #onProgress(progress: Progress): void {
    this.#progress = progress;
    this.#report("progress", progress);
    if (progress.complete && !this.#wasComplete) this.#report("complete", progress);
    this.#wasComplete = progress.complete;
    if (!progress.fault) this.#settleMessage();
  }
}

/** The message for visitors: what happened, then what was expected and found. */
function wordsOf({ kind, message }: StreamError | RendererError): string {
  const isOfAttribute = kind === "bad-address" || kind === "internal";
  return isOfAttribute ? message : `${faults[kind].title}: ${withoutOptions(message)}`;
}

function faultOf(error: unknown): StreamError | RendererError {
  if (error instanceof StreamError || error instanceof RendererError) return error;
  const message = error instanceof Error ? error.message : String(error);
  return new RendererError(message, "internal", error);
}
