import type { Core } from "../core/index.ts";
import { loadCore } from "../core/index.ts";
import {
  type Decoder,
  type Progress,
  type Source,
  type StoreAccess,
  type StoreInfo,
  StreamError,
  StreamSession,
  WorkerPool,
} from "../stream/index.ts";
import { CanvasSize } from "./canvas_size.ts";
import { wholeVolume } from "./clipping.ts";
import { attachControls, type CameraActions } from "./controls.ts";
import { Emitter } from "./emitter.ts";
import { FrameScheduler, type Scene } from "./frame_scheduler.ts";
import { type Light, turnedLight } from "./light.ts";
import { compiledRenderer, RendererError, RendererModule } from "./renderer_module.ts";
import { hasSlices, noSlices, slicePlanes, usableSlices } from "./slices.ts";
import { firstLook, firstSurface } from "./surfaces.ts";
import {
  type Camera,
  type Clip,
  defaultLook,
  type FrameReport,
  type Legend,
  type Look,
  type PictureInParts,
  type PictureView,
  type Projection,
  type Slices,
  type Surface,
  type SurfacePoint,
} from "./types.ts";

export interface ViewerEvents {
  /** A volume is open. Its first surface follows. */
  opened: StoreInfo;
  /** The streaming progress has changed. */
  progress: Progress;
  /** A frame was drawn. */
  frame: FrameReport;
  /** `isBusy` has changed. */
  busy: boolean;
  /** The camera moved, by a gesture or by a call. */
  camera: Camera;
  /** A gesture turned the key light. */
  light: Light;
  /** The source had another volume at the same address, which is open now. */
  replaced: StoreInfo;
  /**
   * Emitted once for each occurrence of a fault (web/stream/faults.ts). Progress.fault is set as
   * long as a streaming fault lasts. The picture stays. If `info` is null afterwards, no volume is
   * open: call open() again.
   */
  error: StreamError | RendererError;
  /** The WebGL context was lost or restored. */
  context: "lost" | "restored";
}

export interface ViewerOptions {
  /**
   * The largest number of samples (16 bytes each) in the GPU's memory. Default: depends on the device's
   * memory (web/stream/device.ts).
   */
  sampleBudget?: number;
  /** Most bytes fetched for other isovalues while a view is complete: see StreamOptions. */
  backgroundBytes?: number;
  /** Cells larger than this on the screen, in pixels, are refined. Default 1. */
  targetCellPixels?: number;
  /** The largest number of device pixels per CSS pixel. Default 2. */
  maxPixelRatio?: number;
  /** Whether mouse, touch and keys on the canvas move the camera. Default true. */
  controls?: boolean;
  /** What the key R does. Default: `Viewer.reset()`. */
  reset?: () => void;
  /** Decodes chunks, and is not closed with the viewer: several may share it. Default: one's own. */
  decoder?: Decoder;
}

export interface OpenOptions {
  /** The isosurfaces of the first view. Default: one, at the volume's first suggestion. */
  surfaces?: readonly Surface[];
  camera?: Camera;
  /** Of the first camera, if there is no `camera`. Default: as it was, at first perspective. */
  projection?: Projection;
  signal?: AbortSignal;
}

/** If a renderer fails within this time (ms) after it was replaced, it is not replaced again. */
const shortestLife = 30_000;

/** Chunks that only slices show are drawn after this time (ms), together. */
const sliceArrivals = 500;

/** Interval in ms between checks whether the first shaders are compiled. */
const shaderPolling = 8;

/**
 * Shows a volume on a canvas: streams what the view needs, and draws when something has changed. Does
 * not depend on the page around the canvas.
 *
 *   const viewer = new Viewer(canvas);
 *   await viewer.open(new ServerSource({ volume: "engine" }));
 *   viewer.setIsovalues([60.5]);
 */
export class Viewer extends Emitter<ViewerEvents> implements CameraActions {
  readonly canvas: HTMLCanvasElement;
  readonly #options: ViewerOptions;
  readonly #size: CanvasSize;
  readonly #cleanup: (() => void)[] = [];
  #parts: Promise<{ renderer: RendererModule; core: Core }> | null = null;
  #renderer: RendererModule | null = null;
  #scheduler: FrameScheduler | null = null;
  #session: StreamSession | null = null;
  #opening: AbortController | null = null;
  #source: Source | null = null;
  /** The viewer's own workers, if it has no `decoder` of others. */
  #workers: WorkerPool | null = null;
  #info: StoreInfo | null = null;

  #camera: Camera | null = null;
  #surfaces: Surface[] = [];
  #look: Look = { ...defaultLook };
  #clip: Clip = wholeVolume;
  #slices: Slices = noSlices;
  #sliceTimer = 0;
  #picture: PictureView | null = null;
  #progress: Progress | null = null;
  /** A picture in parts has begun: nothing else is drawn. */
  #isInParts = false;
  #contextLost = false;
  #isBusy = false;
  #isWarm = false;
  #disposed = false;
  #rendererMadeAt = Number.NEGATIVE_INFINITY;
  #sampleBudget: number | undefined;

  constructor(canvas: HTMLCanvasElement, options: ViewerOptions = {}) {
    super();
    this.canvas = canvas;
    this.#options = options;
    this.#sampleBudget = options.sampleBudget;
    this.#size = new CanvasSize(canvas, options.maxPixelRatio ?? 2, () =>
      this.#scheduler?.request(),
    );
    this.#cleanup.push(() => this.#size.stop());
    if (options.controls !== false) {
      this.#cleanup.push(attachControls(canvas, this, options.reset));
    }

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
   * Creates the renderer and the workers, and compiles shaders, before the first `open`, which then
   * takes less time. Rejects with a RendererError (no WebGL 2).
   */
  async prepare(): Promise<void> {
    if (!this.#options.decoder) this.#ownWorkers();
    await this.#loadParts();
    this.#warmUp();
  }

  /**
   * Shows another volume instead of the present one. Resolves when its header has been read; the surface
   * follows. Rejects with a StreamError, a RendererError (no WebGL 2), or the signal's reason.
   */
  async open(source: Source, options: OpenOptions = {}): Promise<StoreInfo> {
    if (this.#disposed) throw new RendererError("the viewer was disposed of: make another");
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
      if (abortOf(error)) {
        // The instance has aborted. The next open() creates another one.
        this.#renderer = null;
        this.#parts = null;
      }
      throw error;
    }
  }

  async #openSession(
    source: Source,
    options: OpenOptions,
    signal: AbortSignal,
  ): Promise<StoreInfo> {
    // Workers and the store's header load at the same time as the renderer.
    source.warm();
    const decoder = this.#options.decoder ?? this.#ownWorkers();
    const cameraBefore = this.#camera;
    const { renderer, core } = await this.#loadParts();
    signal.throwIfAborted();
    if (options.surfaces) this.#surfaces = [...options.surfaces];
    const { targetCellPixels, backgroundBytes } = this.#options;
    const sampleBudget = this.#sampleBudget;
    const streaming = {
      ...(sampleBudget ? { sampleBudget } : {}),
      ...(targetCellPixels ? { targetCellPixels } : {}),
      ...(backgroundBytes === undefined ? {} : { backgroundBytes }),
    };
    const firstIsovalues = this.#surfaces.map((surface) => surface.isovalue);
    const session = await StreamSession.open(source, core, {
      events: {
        samples: (id, place, samples, clusters) => {
          // The volume is opened again when the context is restored.
          if (this.#contextLost) return true;
          const isTaken = this.#guard((renderer) =>
            renderer.addChunk(id, place, samples, clusters),
          );
          if (isTaken) {
            this.#scheduler?.onUpload(id);
            this.#onSliceChange();
          }
          return isTaken || this.#contextLost;
        },
        drop: (id) => {
          this.#guard((renderer) => renderer.removeChunk(id));
          this.#onSliceChange();
        },
        visible: (ids, regions) => {
          this.#guard((renderer) => renderer.setVisible(ids, regions));
          this.#scheduler?.onVisibleChange();
        },
        testOcclusion: () => this.#scheduler?.request(),
        progress: (progress) => {
          this.#scheduler?.onProgress(progress);
          this.#progress = progress;
          this.emit("progress", progress);
        },
        error: (error) => this.#streamFailed(error),
        replaced: () => void this.#openReplacement(),
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
    if (!options.surfaces) this.#surfaces = [firstSurface(session.info)];
    this.#warmUp();
    renderer.setVolume(session.info);
    this.#setFirstCamera(renderer, options, cameraBefore);
    this.#applySettings();
    this.emit("opened", session.info);
    this.#scheduler?.request();
    return session.info;
  }

  #ownWorkers(): WorkerPool {
    this.#workers ??= new WorkerPool({ renderer: compiledRenderer() });
    return this.#workers;
  }

  /** `options`: those of `open()`; `before`: the camera when that was called. */
  #setFirstCamera(
    renderer: RendererModule,
    { camera: asked, projection }: OpenOptions,
    before: Camera | null,
  ) {
    if (!asked) {
      this.#camera = this.#firstCamera(renderer, projection);
    } else if (this.#camera && this.#camera !== before) {
      // It was moved while the volume was opened again: listeners know that camera.
      this.setCamera(this.#camera);
    } else {
      this.#camera = renderer.bounded(asked);
    }
  }

  /** Changes `ViewerOptions.sampleBudget`, also of the volume that is open. */
  setSampleBudget(samples: number): void {
    this.#sampleBudget = samples;
    this.#session?.setSampleBudget(samples);
  }

  /** Retries at once: requests that wait for their next attempt, and parts that have failed. */
  retry(): void {
    this.#session?.retry();
  }

  /** Closes the volume: ends its requests, and frees its memory. The canvas keeps its picture. */
  close(): void {
    this.#scheduler?.onVolumeChange();
    clearTimeout(this.#sliceTimer);
    this.#sliceTimer = 0;
    this.#opening?.abort(
      new DOMException("the volume was closed, or another was opened", "AbortError"),
    );
    this.#opening = null;
    this.#session?.close();
    this.#session = null;
    this.#source = null;
    this.#info = null;
    this.#showBusy();
  }

  /** Closes the volume and frees everything. The viewer must not be used afterwards. */
  dispose(): void {
    if (this.#disposed) return;
    this.#disposed = true;
    this.close();
    this.#scheduler?.stop();
    this.#workers?.close();
    for (const clean of this.#cleanup) clean();
    this.#renderer?.destroy();
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
    this.#renderer?.setSurfaces(this.#surfaces);
    this.#session?.sceneChanged();
    this.#scheduler?.onCameraChange();
  }

  /** Changes the isovalues and keeps the colours. Additional surfaces get the colour of the first. */
  setIsovalues(isovalues: readonly number[]): void {
    const first = this.#surfaces[0] ?? { isovalue: 0, ...firstLook };
    this.setSurfaces(
      isovalues.map((isovalue, i) => ({ ...(this.#surfaces[i] ?? first), isovalue })),
    );
  }

  /** StreamSession.bytesOf; undefined while no volume is open. */
  bytesOf(isovalue: number): number | undefined {
    return this.#session?.bytesOf(isovalue);
  }

  /** StreamSession.access; undefined while no volume is open. */
  get storeAccess(): StoreAccess | undefined {
    return this.#session?.access;
  }

  /** StreamSession.quantizedIsovalue; undefined while no volume is open. */
  quantizedIsovalue(isovalue: number): number | undefined {
    return this.#session?.quantizedIsovalue(isovalue);
  }

  get look(): Readonly<Look> {
    return this.#look;
  }

  setLook(change: Partial<Look>): void {
    this.#look = { ...this.#look, ...change };
    this.#applySettings();
    // A slider that is dragged is a motion: else pictures with and without occlusion would alternate.
    this.#scheduler?.onCameraChange();
  }

  /**
   * The meaning of colours; null if no volume is open, or each surface has its own colour and there are no
   * slices.
   */
  get legend(): Legend | null {
    const { colourBy, colourMap } = this.#look;
    if (!this.#renderer || !this.#info) return null;
    const slices = hasSlices(this.#slices);
    if (colourBy === "isosurface") {
      if (!slices) return null;
      const range = this.#slices.range ?? this.#info.range;
      return { colourBy: "isovalue", colours: ["#000", "#fff"], range, slices };
    }
    const colours = this.#renderer.colours(colourMap, 16);
    const legend: Legend = { colourBy, colours, range: this.#mappedRange() };
    if (slices) legend.slices = slices;
    if (slices && colourBy !== "isovalue") legend.greys = this.#slices.range ?? this.#info.range;
    return legend;
  }

  /** The range shown in the legend; null if it differs from view to view. */
  #mappedRange(): [number, number] | null {
    switch (this.#look.colourBy) {
      case "depth":
        return null; // depends on the view
      case "level":
        return [0, 7];
      case "projection-error":
        return [0, 0.5];
      default:
        return this.#colourRange();
    }
  }

  get clip(): Clip {
    return this.#clip;
  }

  setClip(clip: Clip): void {
    this.#clip = clip;
    this.#renderer?.setClip(clip);
    this.#session?.sceneChanged();
    this.#scheduler?.onCameraChange();
  }

  get slices(): Slices {
    return this.#slices;
  }

  setSlices(slices: Slices): void {
    this.#slices = usableSlices(slices);
    this.#applySlices();
    this.#session?.sceneChanged();
    this.#scheduler?.onCameraChange();
  }

  #applySlices(): void {
    const info = this.#info;
    const range = this.#slices.range ?? info?.range;
    if (info && range) this.#renderer?.setSlices(slicePlanes(this.#slices, info), range);
  }

  /**
   * A chunk has come or gone. Slices show chunks that the view does not: such as those that are fetched
   * for other isovalues.
   */
  #onSliceChange(): void {
    if (!hasSlices(this.#slices) || this.#sliceTimer !== 0) return;
    this.#sliceTimer = window.setTimeout(() => {
      this.#sliceTimer = 0;
      this.#scheduler?.request(); // a view at rest stays as fine as it is
      this.#showBusy();
    }, sliceArrivals);
    this.#showBusy();
  }

  /** Null until a volume is open. */
  get camera(): Camera | null {
    return this.#camera;
  }

  /**
   * Sets the camera. Distance and angles are limited to what can be drawn. If a number is not finite
   * or the target is too far from the volume, the default camera is used.
   */
  setCamera(camera: Camera): void {
    const bounded = this.#renderer && this.#info ? this.#renderer.bounded(camera) : camera;
    this.#camera = bounded;
    this.emit("camera", bounded);
    this.#scheduler?.onCameraChange();
  }

  /**
   * World to clip space for a picture of this size: 4 × 4, column by column. Null until a volume is
   * open.
   */
  viewProjection(width: number, height: number): Float64Array | null {
    if (!this.#renderer || !this.#camera || !this.#info) return null;
    return this.#renderer.viewProjection(this.#camera, Math.max(1, width), Math.max(1, height));
  }

  /** The first view of the volume, in which all of it is seen. Null until a volume is open. */
  get wholeView(): Camera | null {
    return this.#renderer && this.#info ? this.#firstCamera(this.#renderer) : null;
  }

  /** Returns to the first view of the volume. */
  reset(): void {
    if (this.#renderer && this.#info) this.setCamera(this.#firstCamera(this.#renderer));
  }

  #firstCamera(renderer: RendererModule, projection = this.#camera?.projection): Camera {
    return renderer.defaultCamera(this.#size.aspect, projection);
  }

  /** Changes between perspective and parallel rays. What is at the target keeps its size. */
  setProjection(projection: Projection): void {
    if (this.#camera) this.setCamera({ ...this.#camera, projection });
  }

  orbit(rightDegrees: number, upDegrees: number): void {
    if (this.#renderer && this.#camera) {
      this.setCamera(this.#renderer.orbited(this.#camera, rightDegrees, upDegrees));
    }
  }

  pan(rightPx: number, downPx: number): void {
    if (this.#renderer && this.#camera) {
      const height = this.#size.cssHeight;
      this.setCamera(this.#renderer.panned(this.#camera, rightPx, downPx, height));
    }
  }

  zoom(factor: number, at: { x: number; y: number } = { x: 0, y: 0 }): void {
    if (!this.#renderer || !this.#camera) return;
    const before = this.#camera;
    const zoomed = this.#renderer.zoomed(before, factor);
    // The point under the pointer stays there.
    const keep = 1 - before.distance / zoomed.distance;
    const height = this.#size.cssHeight;
    this.setCamera(this.#renderer.panned(zoomed, at.x * keep, at.y * keep, height));
  }

  /**
   * The nearest surface, or value of a slice, at a place of the canvas (CSS pixels from its upper left
   * corner). Of a surface: the ray's first intersection with the trilinear function of a visible cell.
   * Undefined where there is none, or no picture. `toNext` sees what is visible only: occluded regions
   * may be left out.
   */
  pick(x: number, y: number): SurfacePoint | undefined {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (!this.#camera || !this.#info || this.#contextLost || width === 0) return undefined;
    const camera = this.#camera;
    let point: SurfacePoint | undefined;
    this.#guard((renderer) => {
      renderer.setCamera(camera);
      const pick = renderer.pick(x, y, width, height);
      if (!pick) return;
      const { position, voxel, normal, gradient, toNext, value, level, face } = pick;
      point = { position, voxel, normal, gradient, isovalue: value, level };
      if (toNext > 0) point.toNext = toNext;
      if (face === 1) point.cap = true;
      if (face === 2) point.slice = true;
    });
    return point;
  }

  turnLight(rightDegrees: number, upDegrees: number): void {
    const light = turnedLight(this.#look.light, rightDegrees, upDegrees);
    this.setLook({ light });
    this.emit("light", light);
  }

  /**
   * The present picture, at the canvas's resolution. smooth: draws several times to smooth edges, even
   * if that takes long. transparent: without the background.
   */
  async screenshot({ smooth = true, transparent = false } = {}): Promise<Blob> {
    const scheduler = this.#scheduler;
    if (!scheduler || this.#contextLost) throw new RendererError("nothing is drawn yet");
    const setOpacity = (opacity: number) =>
      this.#guard((renderer) => renderer.setLook(this.#look, this.#colourRange(), opacity));
    if (transparent) setOpacity(0);
    try {
      scheduler.drawToSave(smooth);
      // In the same task, because the browser may clear the drawing buffer afterwards. It copies the
      // picture at once: what is drawn next, with its background, does not change it.
      return new Promise((resolve, reject) =>
        this.canvas.toBlob((blob) => {
          if (blob) resolve(blob);
          else reject(new RendererError("the browser made no picture of the canvas"));
        }, "image/png"),
      );
    } finally {
      if (transparent) {
        setOpacity(1);
        scheduler.request();
      }
    }
  }

  /**
   * Prepares a picture, of any size and of another view: streams what it needs, as `isBusy` tells, and
   * shows it in the canvas. Null: the canvas has its own view again.
   */
  preparePicture(view: PictureView | null): void {
    this.#picture = view;
    this.#scheduler?.onCameraChange();
  }

  /** What is still missing of the present view; null before the first report. */
  get progress(): Progress | null {
    return this.#progress;
  }

  /**
   * Begins the picture that was prepared, of at most 16384 × 16384 pixels. It is drawn in parts with
   * smooth edges, from what is resident. Nothing else is drawn until its `end`. transparent: without the
   * background. Throws a RendererError.
   */
  beginPicture({ transparent = false } = {}): PictureInParts {
    const { width, height } = this.#picture ?? this.canvas;
    const camera = this.#picture?.camera ?? this.#camera;
    if (!camera || !this.#session || this.#contextLost) {
      throw new RendererError("nothing is drawn yet");
    }
    const must = (action: (renderer: RendererModule) => void): void => {
      let isDone = false;
      if (!this.#contextLost) isDone = this.#guard(action);
      if (!isDone) throw new RendererError("the GPU could not draw the picture: try a smaller one");
    };
    const { kind, shading } = this.#look;
    const setOpacity = (renderer: RendererModule, opacity: number) =>
      renderer.setLook(this.#look, this.#colourRange(), opacity);
    this.#isInParts = true;
    const end = (): void => {
      if (!this.#isInParts) return;
      this.#isInParts = false;
      this.#guard((renderer) => {
        renderer.endTiles();
        setOpacity(renderer, 1);
      });
      this.#scheduler?.onCameraChange();
    };
    try {
      must((renderer) => {
        renderer.setCamera(camera);
        renderer.setSplats({ kind: kind === "automatic" ? "exact" : kind, shading });
        setOpacity(renderer, transparent ? 0 : 1);
        renderer.beginTiles(width, height);
      });
    } catch (error) {
      end();
      throw error;
    }
    const draw = (x: number, y: number, partWidth: number, partHeight: number) => {
      let part = new Uint8ClampedArray();
      must((renderer) => {
        part = renderer.drawTile(x, y, partWidth, partHeight);
      });
      return part;
    };
    return { width, height, draw, end };
  }

  #loadParts(): Promise<{ renderer: RendererModule; core: Core }> {
    this.#parts ??= RendererModule.create(this.canvas).then(async (renderer) => {
      if (this.#disposed) {
        renderer.destroy();
        throw new DOMException("the viewer was disposed of", "AbortError");
      }
      this.#renderer = renderer;
      this.#scheduler = this.#newPicture(renderer);
      return { renderer, core: await loadCore({ module: renderer.exports }) };
    });
    // After a failure, the next open() tries again.
    this.#parts.catch(() => {
      this.#parts = null;
    });
    return this.#parts;
  }

  /** Waits for the shaders without blocking the workers and the first samples. */
  #warmUp(): void {
    if (this.#isWarm) return;
    setTimeout(
      () =>
        this.#guard((renderer) => {
          if (this.#scheduler?.isBegun || this.#isWarm || this.#disposed) return;
          this.#isWarm = renderer.isCompiled();
          if (this.#isWarm) renderer.warmUp();
          else this.#warmUp();
        }),
      shaderPolling,
    );
  }

  #applySettings(): void {
    const renderer = this.#renderer;
    if (!renderer) return;
    renderer.setSurfaces(this.#surfaces);
    renderer.setClip(this.#clip);
    renderer.setLook(this.#look, this.#colourRange());
    this.#applySlices();
  }

  /** The range of values, or of gradients, that is passed to the renderer for colouring. */
  #colourRange(): [number, number] {
    const info = this.#info;
    if (!info) return [0, 1];
    const [low, high] = info.range;
    if (this.#look.colourBy !== "gradient") return [low, high];
    // The largest gradient of the scale: half of the range of values across one cell, a sharp edge.
    return [0, (0.5 * (high - low)) / Math.min(...info.spacing)];
  }

  /**
   * Whether the picture will change without further calls: a volume, data, finer splats or smoother
   * edges are still coming.
   */
  get isBusy(): boolean {
    return this.#isBusy;
  }

  #showBusy(): void {
    const isDrawing =
      this.#session === null ||
      this.#contextLost ||
      this.#sliceTimer !== 0 ||
      this.#scheduler?.isBusy;
    const isBusy = this.#opening !== null && isDrawing !== false;
    if (isBusy === this.#isBusy) return;
    this.#isBusy = isBusy;
    this.emit("busy", isBusy);
  }

  #newPicture(renderer: RendererModule): FrameScheduler {
    this.#scheduler?.stop();
    return new FrameScheduler(this.canvas, renderer, {
      scene: () => this.#scene(),
      guard: (action) => this.#guard(action),
      checkGpu: (ids) => this.#checkGpu(ids),
      isContextLost: () => this.#contextLost,
      fitCanvas: () => this.#size.fit(),
      drawn: (report) => this.emit("frame", report),
      busyChanged: () => this.#showBusy(),
    });
  }

  #scene(): Scene | null {
    if (!this.#renderer || !this.#camera || !this.#session || this.#contextLost) return null;
    if (this.#isInParts) return null;
    return {
      session: this.#session,
      camera: this.#picture?.camera ?? this.#camera,
      isovalues: this.#surfaces.map((surface) => surface.isovalue),
      kind: this.#look.kind,
      shading: this.#look.shading,
      pictureSize: this.#picture,
    };
  }

  /**
   * Runs `action`, which may fail, and returns whether it succeeded. A lost context is not an
   * error: it is restored later. Streaming reports a full GPU memory, and continues with a smaller
   * budget.
   */
  #guard(action: (renderer: RendererModule) => void): boolean {
    if (!this.#renderer) return false;
    try {
      action(this.#renderer);
      return true;
    } catch (error) {
      if (this.#isWithoutContext()) return false;
      if (error instanceof RendererError) {
        if (error.kind !== "out-of-memory") this.emit("error", error);
      } else if (error instanceof WebAssembly.RuntimeError) {
        this.#replaceRenderer(error);
      } else {
        // An error in JavaScript; the renderer still works.
        this.emit("error", new RendererError(String(error), "internal", error));
      }
      return false;
    }
  }

  #isWithoutContext(): boolean {
    return this.#contextLost || this.canvas.getContext("webgl2")?.isContextLost() === true;
  }

  #checkGpu(ids: readonly number[]): void {
    this.#guard((renderer) => {
      try {
        renderer.checkGpu();
      } catch (error) {
        if (!(error instanceof RendererError) || error.kind !== "out-of-memory") throw error;
        this.#session?.rejectUploads(ids, error.message);
      }
    });
  }

  #streamFailed(error: StreamError): void {
    // Streaming uses the core of the renderer's instance.
    const abort = abortOf(error);
    if (abort) this.#replaceRenderer(abort);
    else this.emit("error", error);
  }

  /** The instance has aborted and cannot continue. Opens the volume again with another one. */
  #replaceRenderer(error: WebAssembly.RuntimeError): void {
    if (!this.#renderer) return;
    this.#renderer = null;
    this.#parts = null;
    this.#isWarm = false;
    this.#scheduler?.stop();
    const givesUp = performance.now() - this.#rendererMadeAt < shortestLife;
    this.#rendererMadeAt = performance.now();
    // In a task of its own, not within the call that failed.
    setTimeout(() => {
      if (this.#disposed) return;
      if (givesUp) {
        this.close();
        this.emit("error", new RendererError(String(error), "renderer-failed", error));
        return;
      }
      // Losing the context frees what the old instance has in the GPU's memory.
      const context = this.canvas.getContext("webgl2");
      const loss = context?.getExtension("WEBGL_lose_context");
      if (!context || !loss || context.isContextLost()) {
        void this.#reopen();
        return;
      }
      const restore = (): void => {
        this.canvas.removeEventListener("webglcontextlost", restore);
        setTimeout(() => loss.restoreContext());
      };
      this.canvas.addEventListener("webglcontextlost", restore);
      loss.loseContext();
    });
  }

  #onContextLost(event: Event): void {
    event.preventDefault(); // otherwise the browser does not restore it
    this.#contextLost = true;
    this.#scheduler?.onContextLost();
    this.#renderer?.contextLost();
    this.#showBusy();
    this.emit("context", "lost");
  }

  /** The chunks were lost with the context. They are read again, mostly from the browser's cache. */
  #onContextRestored(): void {
    this.#contextLost = false;
    this.#guard((renderer) => renderer.contextRestored());
    this.emit("context", "restored");
    void this.#reopen();
  }

  /** Opens the volume that is now at the source's address, with the present view. */
  async #reopen(): Promise<StoreInfo | undefined> {
    const source = this.#source;
    if (!source) return undefined;
    const options: OpenOptions = {};
    if (this.#surfaces.length > 0) options.surfaces = this.#surfaces;
    if (this.#camera) options.camera = this.#camera;
    source.forget();
    try {
      return await this.open(source, options);
    } catch (error) {
      if (error instanceof StreamError || error instanceof RendererError) this.emit("error", error);
      return undefined;
    }
  }

  async #openReplacement(): Promise<void> {
    const before = this.#info;
    const info = await this.#reopen();
    if (!info) return;
    // In another grid, the camera might not look at the volume.
    if (!before || !isSameGrid(before, info)) this.reset();
    this.emit("replaced", info);
  }
}

/** The trap that an error comes from: the instance has aborted. */
function abortOf(error: unknown): WebAssembly.RuntimeError | undefined {
  for (let cause = error; cause instanceof Error; cause = cause.cause) {
    if (cause instanceof WebAssembly.RuntimeError) return cause;
  }
  return undefined;
}

function isSameGrid(a: StoreInfo, b: StoreInfo): boolean {
  const numbers = ({ voxels, spacing, origin, direction }: StoreInfo): number[] => [
    ...voxels,
    ...spacing,
    ...origin,
    ...direction,
  ];
  const other = numbers(b);
  return numbers(a).every((number, i) => number === other[i]);
}
