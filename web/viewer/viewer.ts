import type { Core } from "../core/index.ts";
import { loadCore } from "../core/index.ts";
import {
  measured,
  type Progress,
  type Source,
  type StoreInfo,
  StreamError,
  StreamSession,
  WorkerPool,
} from "../stream/index.ts";
import { wholeVolume } from "./clipping.ts";
import { attachControls, type CameraActions } from "./controls.ts";
import { Emitter } from "./emitter.ts";
import { Fade } from "./fade.ts";
import { FrameLoop } from "./frame_loop.ts";
import { GpuTimer } from "./gpu_timer.ts";
import { SightTester } from "./sight_tester.ts";
import { SplatChoice } from "./splat_choice.ts";
import {
  type Camera,
  type Clip,
  defaultLook,
  type FrameReport,
  type Look,
  type SplatKind,
  type Surface,
} from "./types.ts";
import { compiledView, type DrawStatistics, ViewError, ViewModule } from "./view_module.ts";

export interface ViewerEvents {
  /** A volume is open; its first surface is on its way. */
  opened: StoreInfo;
  /** Streaming went on; see Progress. */
  progress: Progress;
  /** A frame was drawn. */
  frame: FrameReport;
  /** See isBusy: it has changed. */
  busy: boolean;
  /** The camera moved, by a gesture or by a call. */
  camera: Camera;
  /** A StreamError that says `retrying` needs no action; after any other the picture stays as it is. */
  error: StreamError | ViewError;
  /** The browser took the GPU away, and gave it back. */
  context: "lost" | "restored";
}

export interface ViewerOptions {
  /** Most samples (16 bytes each) held on the GPU. Default: by device class. */
  sampleBudget?: number;
  /** Cells are refined until they are no larger than this on the screen, in pixels. Default 1. */
  targetCellPixels?: number;
  /** Device pixels per CSS pixel, at most. Default 2. */
  maxPixelRatio?: number;
  /** Mouse, touch and keys on the canvas. Default true. */
  controls?: boolean;
}

export interface OpenOptions {
  /** The isosurfaces of the first view. Default: the volume's first suggestion. */
  surfaces?: readonly Surface[];
  camera?: Camera;
  signal?: AbortSignal;
}

/** The view rests when nothing has moved or arrived for so long (ms). */
const restAfter = 220;
/** A picture of a resting view that takes no longer (ms) is drawn a few times more, for smooth edges. */
const longestSmoothed = 400;
/** While a picture is being drawn, it is looked again after so long (ms). */
const shortestWait = 8;
/** Arrivals fade in where a picture takes no longer (ms). */
const longestFaded = 50;
/** The GPU is asked so often whether the first shaders are compiled (ms). */
const shaderPolling = 8;

/**
 * A volume on a canvas: streams what the view needs, and draws when something has changed. Knows
 * nothing of the page around it.
 *
 *   const viewer = new Viewer(canvas);
 *   await viewer.open(new ServerSource({ volume: "engine" }));
 *   viewer.setIsovalues([60.5]);
 */
export class Viewer extends Emitter<ViewerEvents> implements CameraActions {
  readonly canvas: HTMLCanvasElement;
  readonly #options: ViewerOptions;
  readonly #loop: FrameLoop;
  readonly #cleanup: (() => void)[] = [];
  #parts: Promise<{ view: ViewModule; core: Core }> | null = null;
  #view: ViewModule | null = null;
  #session: StreamSession | null = null;
  #opening: AbortController | null = null;
  #source: Source | null = null;
  #decoder: WorkerPool | null = null;
  #info: StoreInfo | null = null;

  #camera: Camera | null = null;
  #surfaces: Surface[] = [];
  #look: Look = { ...defaultLook };
  #clip: Clip = wholeVolume;
  #lastMotion = Number.NEGATIVE_INFINITY;
  #lastArrival = Number.NEGATIVE_INFINITY;
  #restTimer = 0;
  #drawTimer = 0;
  #chunksToGo = 0;
  /** Of the present view, data are on their way, or are to be asked for. */
  #isStreaming = false;
  /** As of the last frame; nothing has moved or arrived since. */
  #isResting = false;
  #isBusy = false;
  /** From when on what has arrived may be drawn, as long as more is to come. */
  #nextArrivals = 0;
  #contextLost = false;
  readonly #choice = new SplatChoice();
  readonly #sight = new SightTester({
    guard: (action) => this.#guard(action),
    isIdle: () => performance.now() - this.#lastMotion >= restAfter && !this.#timer?.isBusy,
    isContextLost: () => this.#contextLost,
    ended: () => this.#wake(),
  });
  #timer: GpuTimer | null = null;
  #smooths = false;
  #fade: Fade | null = null;
  #fades = false;
  /** Samples went to the GPU, and it has not been asked since whether there was room for them. */
  #hasUnchecked = false;
  #isWarm = false;
  /** Of this volume: until there is one, drawing would only take the GPU's time. */
  #hasPicture = false;
  #disposed = false;

  constructor(canvas: HTMLCanvasElement, options: ViewerOptions = {}) {
    super();
    this.canvas = canvas;
    this.#options = options;
    this.#loop = new FrameLoop((now) => this.#frame(now));

    const observer = new ResizeObserver(() => this.#wake());
    observer.observe(canvas);
    this.#cleanup.push(() => observer.disconnect());
    if (options.controls !== false) this.#cleanup.push(attachControls(canvas, this));

    const lost = (event: Event) => this.#onContextLost(event);
    const restored = () => this.#onContextRestored();
    canvas.addEventListener("webglcontextlost", lost);
    canvas.addEventListener("webglcontextrestored", restored);
    this.#cleanup.push(() => {
      canvas.removeEventListener("webglcontextlost", lost);
      canvas.removeEventListener("webglcontextrestored", restored);
    });
  }

  /**
   * Shows another volume in place of the present one. Resolves when its head is read; the surface
   * follows. Rejects with a StreamError, a ViewError (no WebGL 2), or the signal's reason.
   */
  async open(source: Source, options: OpenOptions = {}): Promise<StoreInfo> {
    this.close();
    const opening = new AbortController();
    this.#opening = opening;
    const abort = () => opening.abort(options.signal?.reason);
    if (options.signal?.aborted) abort();
    options.signal?.addEventListener("abort", abort, { once: true });
    opening.signal.addEventListener("abort", () =>
      options.signal?.removeEventListener("abort", abort),
    );
    this.#showBusy();
    try {
      return await this.#openSession(source, options, opening.signal);
    } catch (error) {
      if (this.#opening === opening) this.close();
      throw error;
    }
  }

  async #openSession(
    source: Source,
    options: OpenOptions,
    signal: AbortSignal,
  ): Promise<StoreInfo> {
    // Workers and the store's head load beside the renderer.
    source.warm();
    this.#decoder ??= new WorkerPool({ view: compiledView() });
    const decoder = this.#decoder;
    const { view, core } = await this.#loadParts();
    signal.throwIfAborted();
    if (options.surfaces) this.#surfaces = [...options.surfaces];
    const { sampleBudget, targetCellPixels } = this.#options;
    const streaming = {
      ...(sampleBudget ? { sampleBudget } : {}),
      ...(targetCellPixels ? { targetCellPixels } : {}),
    };
    const firstIsovalues = this.#surfaces.map((surface) => surface.isovalue);
    const session = await StreamSession.open(source, core, {
      events: {
        samples: (id, place, samples) => {
          if (this.#contextLost) return;
          this.#guard((view) => view.addChunk(id, place, samples));
          this.#hasUnchecked = true;
        },
        drop: (id) => this.#guard((view) => view.removeChunk(id)),
        visible: (ids, regions) => {
          this.#guard((view) => view.setVisible(ids, regions));
          this.#hasPicture = true;
          this.#lastArrival = performance.now();
          this.#isResting = false;
          this.#wake();
        },
        testSight: () => this.#wake(),
        progress: (progress) => {
          const isLast = this.#chunksToGo > 0 && progress.chunksToGo === 0;
          const isEmpty = !this.#hasPicture && progress.state !== "opening";
          this.#chunksToGo = progress.chunksToGo;
          this.#isStreaming = progress.state !== "complete" && progress.state !== "incomplete";
          if (isEmpty) this.#hasPicture = true;
          if (isLast || isEmpty) this.#wake();
          else this.#showBusy();
          this.emit("progress", progress);
        },
        error: (error) => this.emit("error", error),
      },
      signal,
      decoder,
      ...(firstIsovalues.length > 0 && options.surfaces ? { firstIsovalues } : {}),
      ...streaming,
    });
    if (signal.aborted) {
      session.close();
      signal.throwIfAborted();
    }
    this.#session = session;
    this.#source = source;
    this.#info = session.info;
    this.#warmUp();
    view.setVolume(session.info);
    this.#camera = options.camera ?? this.#firstCamera(view);
    this.#applySettings();
    this.emit("opened", session.info);
    this.#wake();
    return session.info;
  }

  /** Asks at once for what waits for its next try, and again for what has failed. */
  retry(): void {
    this.#session?.retry();
  }

  /** Lets go of the volume: its requests, its memory on CPU and GPU. The canvas keeps its picture. */
  close(): void {
    this.#fade?.forget();
    this.#opening?.abort(new DOMException("another volume is opened", "AbortError"));
    this.#opening = null;
    this.#session?.close();
    this.#session = null;
    this.#source = null;
    this.#info = null;
    this.#hasPicture = false;
    this.#isStreaming = false;
    this.#showBusy();
  }

  /** Closes the volume and frees everything. The viewer must not be used afterwards. */
  dispose(): void {
    if (this.#disposed) return;
    this.#disposed = true;
    this.close();
    this.#loop.stop();
    clearTimeout(this.#restTimer);
    clearTimeout(this.#drawTimer);
    this.#sight.stop();
    this.#decoder?.close();
    for (const clean of this.#cleanup) clean();
    this.#view?.destroy();
    this.removeListeners();
  }

  get info(): StoreInfo | null {
    return this.#info;
  }

  get surfaces(): readonly Surface[] {
    return this.#surfaces;
  }

  /** Shows these isosurfaces. What is resident is drawn in the next frame. */
  setSurfaces(surfaces: readonly Surface[]): void {
    this.#surfaces = [...surfaces];
    this.#view?.setSurfaces(this.#surfaces);
    this.#session?.sceneChanged();
    this.#moved();
  }

  /** Changes the isovalues and keeps the surfaces' colours; more isovalues take the first's. */
  setIsovalues(isovalues: readonly number[]): void {
    const first = this.#surfaces[0] ?? { isovalue: 0, colour: "#d9ccb3", opacity: 1 };
    this.setSurfaces(
      isovalues.map((isovalue, i) => ({ ...(this.#surfaces[i] ?? first), isovalue })),
    );
  }

  get look(): Readonly<Look> {
    return this.#look;
  }

  setLook(change: Partial<Look>): void {
    this.#look = { ...this.#look, ...change };
    this.#applySettings();
    this.#wake();
  }

  get clip(): Clip {
    return this.#clip;
  }

  setClip(clip: Clip): void {
    this.#clip = clip;
    this.#view?.setClip(clip);
    this.#session?.sceneChanged();
    this.#moved();
  }

  /** Null until a volume is open. */
  get camera(): Camera | null {
    return this.#camera;
  }

  setCamera(camera: Camera): void {
    this.#camera = camera;
    this.emit("camera", camera);
    this.#moved();
  }

  /** Back to the view a volume is first seen in. */
  reset(): void {
    if (this.#view && this.#info) this.setCamera(this.#firstCamera(this.#view));
  }

  #firstCamera(view: ViewModule): Camera {
    const { clientWidth, clientHeight } = this.canvas;
    return view.defaultCamera(Math.max(clientWidth, 1) / Math.max(clientHeight, 1));
  }

  orbit(rightDegrees: number, upDegrees: number): void {
    if (this.#view && this.#camera) {
      this.setCamera(this.#view.orbited(this.#camera, rightDegrees, upDegrees));
    }
  }

  pan(rightPx: number, downPx: number): void {
    if (this.#view && this.#camera) {
      const height = Math.max(this.canvas.clientHeight, 1);
      this.setCamera(this.#view.panned(this.#camera, rightPx, downPx, height));
    }
  }

  zoom(factor: number, at: { x: number; y: number } = { x: 0, y: 0 }): void {
    if (!this.#view || !this.#camera) return;
    const before = this.#camera;
    const zoomed = this.#view.zoomed(before, factor);
    // What is under the pointer stays there.
    const keep = 1 - before.distance / zoomed.distance;
    const height = Math.max(this.canvas.clientHeight, 1);
    this.setCamera(this.#view.panned(zoomed, at.x * keep, at.y * keep, height));
  }

  /**
   * The picture as it is, at the canvas's resolution. `smooth`: drawn a few times more, however long
   * that takes, for smooth edges.
   */
  async screenshot({ smooth = true } = {}): Promise<Blob> {
    const view = this.#view;
    if (!view || this.#contextLost) throw new ViewError("nothing is drawn yet");
    const { width, height } = this.canvas;
    view.setKind(this.#kind(true));
    this.#fade?.forget();
    view.draw(width, height);
    while (smooth && view.canRefine(width, height)) view.refine(width, height);
    // In the same task: afterwards the browser may have cleared the drawing buffer.
    return new Promise((resolve, reject) =>
      this.canvas.toBlob((blob) => {
        if (blob) resolve(blob);
        else reject(new ViewError("the browser made no picture of the canvas"));
      }, "image/png"),
    );
  }

  #loadParts(): Promise<{ view: ViewModule; core: Core }> {
    this.#parts ??= ViewModule.create(this.canvas).then(async (view) => {
      if (this.#disposed) view.destroy();
      this.#view = view;
      this.#fade = new Fade(view);
      const gl = this.canvas.getContext("webgl2");
      this.#timer = gl && new GpuTimer(gl);
      return { view, core: await loadCore({ module: view.exports }) };
    });
    // A failure is not kept: the next open tries again.
    this.#parts.catch(() => {
      this.#parts = null;
    });
    return this.#parts;
  }

  /** Waits for the shaders without standing in the way of the workers, and of the first samples. */
  #warmUp(): void {
    if (this.#isWarm) return;
    setTimeout(
      () =>
        this.#guard((view) => {
          if (this.#hasPicture || this.#isWarm) return;
          this.#isWarm = view.isCompiled();
          if (this.#isWarm) view.warmUp();
          else this.#warmUp();
        }),
      shaderPolling,
    );
  }

  #applySettings(): void {
    const view = this.#view;
    if (!view) return;
    view.setSurfaces(this.#surfaces);
    view.setClip(this.#clip);
    view.setLook(this.#look, this.#colourRange());
  }

  /** What the ends of the colour map stand for. */
  #colourRange(): [number, number] {
    const info = this.#info;
    if (!info) return [0, 1];
    const [low, high] = info.range;
    if (this.#look.colourBy !== "gradient") return [low, high];
    // Half of the range across one cell is a sharp edge.
    return [0, (0.5 * (high - low)) / Math.min(...info.spacing)];
  }

  /**
   * Whether the picture is still to change by itself: a volume, data, finer splats or smoother edges
   * are on their way.
   */
  get isBusy(): boolean {
    return this.#isBusy;
  }

  #showBusy(): void {
    const isBusy =
      this.#opening !== null &&
      (this.#session === null ||
        this.#isStreaming ||
        !this.#isResting ||
        this.#contextLost ||
        this.#loop.isRequested ||
        this.#sight.isRunning ||
        (this.#timer?.isBusy ?? false) ||
        (this.#fade?.isRunning ?? false));
    if (isBusy === this.#isBusy) return;
    this.#isBusy = isBusy;
    this.emit("busy", isBusy);
  }

  /** Something has changed that the next frame is to show. */
  #wake(): void {
    this.#loop.request();
    this.#showBusy();
  }

  #moved(): void {
    this.#lastMotion = performance.now();
    this.#isResting = false;
    this.#wake();
  }

  #kind(isResting: boolean): SplatKind {
    if (this.#look.kind !== "automatic") return this.#look.kind;
    return this.#choice.kind(isResting, this.#camera?.distance ?? 1);
  }

  /** Answers whether the size has changed, and with that the canvas is empty. */
  #fitCanvas(): boolean {
    const ratio = Math.min(devicePixelRatio, this.#options.maxPixelRatio ?? 2);
    const width = Math.max(1, Math.round(this.canvas.clientWidth * ratio));
    const height = Math.max(1, Math.round(this.canvas.clientHeight * ratio));
    if (this.canvas.width === width && this.canvas.height === height) return false;
    this.canvas.width = width;
    this.canvas.height = height;
    return true;
  }

  /**
   * What has arrived waits as long as the last picture took, where nothing moves and more is to
   * come: a slow GPU would else draw every few chunks anew, and take the processor's time from those
   * that follow.
   */
  #mayDraw(now: number): boolean {
    if (this.#chunksToGo === 0) return true;
    const wait = this.#timer?.isBusy ? shortestWait : this.#nextArrivals - now;
    if (wait <= 0) return true;
    clearTimeout(this.#drawTimer);
    this.#drawTimer = window.setTimeout(() => this.#wake(), wait);
    return false;
  }

  /** Answers whether another frame is to follow at once. */
  #frame(now: number): boolean {
    const view = this.#view;
    const camera = this.#camera;
    if (!view || !camera || !this.#session || this.#contextLost) return false;
    const isResized = this.#fitCanvas();
    const { width, height } = this.canvas;
    const quietSince = Math.max(this.#lastMotion, this.#lastArrival);
    const isMoving = now - this.#lastMotion < restAfter;
    const isResting = now - quietSince >= restAfter;
    this.#isResting = isResting;

    view.setCamera(camera);
    const kind = this.#kind(isResting);
    view.setKind(kind);
    this.#session.update({
      viewProjection: view.viewProjection(camera, width, height),
      viewport: { width, height },
      isovalues: this.#surfaces.map((surface) => surface.isovalue),
      moving: isMoving,
    });
    const isTesting = this.#sight.isRunning;
    if (this.#hasPicture && view.needsRedraw(width, height)) {
      if (isMoving || isResized || (!isTesting && this.#mayDraw(now))) {
        if (isMoving || isResized) this.#fade?.forget();
        this.#guard(() => this.#fade?.beforeDraw(now));
        this.#draw(isResting, () => view.draw(width, height));
        if (isMoving || !this.#fades) this.#fade?.forget();
        else this.#guard(() => this.#fade?.afterDraw(now, this.#chunksToGo > 0));
      }
    } else if (this.#fade?.isRunning) {
      this.#guard(() => this.#fade?.step(now, this.#chunksToGo > 0));
    } else if (isResting && !isTesting && this.#smooths && view.canRefine(width, height)) {
      this.#draw(true, () => view.refine(width, height));
    }
    if (!isMoving && !view.needsRedraw(width, height)) {
      this.#sight.test(this.#session, isResting || kind === this.#kind(true));
    }
    // Once more when it has come to rest: for the finer splats, and so that streaming refines.
    clearTimeout(this.#restTimer);
    if (!isResting) {
      const wait = Math.max(0, quietSince + restAfter - now) + 1;
      this.#restTimer = window.setTimeout(() => this.#wake(), wait);
    }
    this.#showBusy();
    return this.#fade?.isRunning ?? false;
  }

  #draw(isResting: boolean, draw: () => DrawStatistics): void {
    const distance = this.#camera?.distance ?? 1;
    this.#guard(() => {
      const startedAt = performance.now();
      const drawn = measured("isosplat:drawing", draw);
      this.#timer?.measure(startedAt, (milliseconds) => {
        this.#choice.measured(drawn, milliseconds, distance);
        this.#nextArrivals = performance.now() + milliseconds;
        this.#fades = milliseconds <= longestFaded;
        if (!isResting) {
          this.#showBusy();
          return;
        }
        // Now the GPU has little else to do: asking it while frames follow each other would wait.
        if (this.#hasUnchecked) this.#guard((view) => view.checkGpu());
        this.#hasUnchecked = false;
        // One at a time, so that a gesture need not wait for more than one.
        this.#smooths = milliseconds <= longestSmoothed;
        if (this.#smooths) this.#wake();
        else this.#showBusy();
      });
      this.emit("frame", { ...drawn, framesPerSecond: this.#loop.framesPerSecond });
    });
  }

  /**
   * Does what may fail in the renderer; says whether it did not. A context that is lost is no
   * error: it comes back.
   */
  #guard(action: (view: ViewModule) => void): boolean {
    if (!this.#view) return false;
    try {
      action(this.#view);
      return true;
    } catch (error) {
      if (this.#contextLost || this.canvas.getContext("webgl2")?.isContextLost()) return false;
      if (!(error instanceof ViewError)) {
        // The instance has aborted, and cannot go on: the next open makes another.
        this.#view = null;
        this.#parts = null;
      }
      this.emit("error", error instanceof ViewError ? error : new ViewError(String(error)));
      return false;
    }
  }

  #onContextLost(event: Event): void {
    event.preventDefault(); // asks the browser to restore it
    this.#contextLost = true;
    this.#fade?.forget();
    this.#view?.contextLost();
    this.#showBusy();
    this.emit("context", "lost");
  }

  /** The chunks went with the context. They are read again, mostly from the browser's cache. */
  #onContextRestored(): void {
    const source = this.#source;
    this.#contextLost = false;
    this.#guard((view) => view.contextRestored());
    this.emit("context", "restored");
    if (!source) return;
    const options: OpenOptions = { surfaces: this.#surfaces };
    if (this.#camera) options.camera = this.#camera;
    this.open(source, options).catch((error: unknown) => {
      if (error instanceof StreamError || error instanceof ViewError) this.emit("error", error);
    });
  }
}
