import type { Core } from "../core/core.ts";
import type { Bins, Category, StoreInfo } from "../core/types.ts";
import type { StoreAccess } from "../stream/session_parts.ts";
import type { Source } from "../stream/source.ts";
import type { Progress } from "../stream/types.ts";
import { CanvasSize } from "./canvas_size.ts";
import { attachControls, type CameraActions } from "./controls.ts";
import { Emitter } from "./emitter.ts";
import { usableField } from "./field_of.ts";
import { FrameScheduler } from "./frame_scheduler.ts";
import type { Layer } from "./layer.ts";
import type { StepSources } from "./layer_steps.ts";
import { Layers } from "./layers.ts";
import { turnedLight } from "./light.ts";
import { PictureSettings } from "./picture_settings.ts";
import { RendererLife } from "./renderer_life.ts";
import type { RendererModule } from "./renderer_module.ts";
import { SavedPictures } from "./saved_pictures.ts";
import { SliceArrivals } from "./slice_arrivals.ts";
import { pickedPoint } from "./surface_point.ts";
import { withIsovalues } from "./surfaces.ts";
import type { SceneTime, Time } from "./time.ts";
import {
  type Camera,
  type Clip,
  defaultLook,
  type Legend,
  type Look,
  type LookChange,
  type PartsOptions,
  type PictureInParts,
  type PictureView,
  type Projection,
  type Slices,
  type Surface,
  type SurfacePoint,
} from "./types.ts";
import { ViewCamera } from "./view_camera.ts";
import type { AddLayerOptions, OpenOptions, ViewerEvents, ViewerOptions } from "./viewer_events.ts";

/**
 * Shows volumes on a canvas: streams what the view needs, and draws when something has changed. Does
 * not depend on the page around the canvas. Members that concern one volume refer to the first layer (`layers`).
 *
 *   const viewer = new Viewer(canvas);
 *   await viewer.open(new ServerSource({ volume: "engine" }));
 *   viewer.setIsovalues([60.5]);
 */
export class Viewer extends Emitter<ViewerEvents> implements CameraActions {
  readonly canvas: HTMLCanvasElement;
  readonly #size: CanvasSize;
  readonly #detachControls: () => void;
  readonly #life: RendererLife;
  #scheduler: FrameScheduler | null = null;
  readonly #layers: Layers;
  readonly #settings = new PictureSettings();
  readonly #camera: ViewCamera;
  readonly #sliceArrivals: SliceArrivals;
  readonly #pictures: SavedPictures;
  #isBusy = false;

  constructor(canvas: HTMLCanvasElement, options: ViewerOptions = {}) {
    super();
    this.canvas = canvas;
    const request = () => this.#scheduler?.request();
    this.#size = new CanvasSize(canvas, options.maxPixelRatio ?? 2, request);
    this.#sliceArrivals = new SliceArrivals(request, () => this.#showBusy());
    this.#camera = new ViewCamera(this.#size, {
      renderer: () => this.#life.renderer,
      info: () => this.info,
      moved: (camera) => {
        this.emit("camera", camera);
        this.#scheduler?.onCameraChange();
      },
    });
    this.#detachControls =
      options.controls === false ? () => {} : attachControls(canvas, this, options.reset);
    this.#life = new RendererLife(canvas, {
      made: (renderer) => this.#schedule(renderer),
      isDrawing: () => this.#scheduler?.isBegun === true,
      aborted: () => this.#scheduler?.stop(),
      reopen: () => void this.#layers.reopen(),
      givesUp: (error) => {
        this.close();
        this.emit("error", error);
      },
      failed: (error) => this.emit("error", error),
      contextChanged: (state) => {
        if (state === "lost") this.#scheduler?.onContextLost();
        if (state === "lost") this.#showBusy();
        this.emit("context", state);
      },
    });
    this.#layers = new Layers(options, this.#life, this.#settings, this.#camera, {
      scheduler: () => this.#scheduler,
      emit: (name, detail) => this.emit(name, detail),
      pictureEnds: () => {
        this.#scheduler?.onVolumeChange();
        this.#sliceArrivals.stop();
      },
      busyChanged: () => this.#showBusy(),
      chunksChanged: () => this.#settings.hasSlices && this.#sliceArrivals.changed(),
    });
    this.#pictures = new SavedPictures(canvas, this.#life, {
      scheduler: () => this.#scheduler,
      camera: () => this.camera,
      isOpen: () => this.#layers.list.isOpen,
      look: () => this.look,
      applyLook: (renderer, opacity) => this.#layers.applyLook(renderer, opacity),
    });
  }

  /**
   * Creates the renderer and the workers, and compiles shaders, before the first `open`, which then
   * takes less time. Rejects with a RendererError (no WebGL 2).
   */
  prepare(): Promise<void> {
    return this.#layers.prepare();
  }

  /** The core of the renderer's instance. Rejects as `prepare`. */
  async core(): Promise<Core> {
    return (await this.#life.load()).core;
  }

  /**
   * Shows another volume instead of all present layers. Resolves when its header has been read; the surface
   * follows. Rejects with a StreamError, a RendererError (no WebGL 2), or the signal's reason.
   */
  open(source: Source, options: OpenOptions = {}): Promise<StoreInfo> {
    return this.#layers.open(source, options);
  }

  /**
   * Adds a volume to the picture. Resolves when its header has been read, or at once if it is hidden: its header
   * is then read when it is shown. `source` may be a function that makes the source of each step of `time`.
   * Rejects with the errors of `open`, and with a RangeError for an invalid transform; the other layers stay.
   */
  addLayer(source: Source | StepSources, options: AddLayerOptions = {}): Promise<Layer> {
    return this.#layers.add(source, options);
  }

  /** The steps of the scene; null if it does not change with time. */
  get time(): Time | null {
    return this.#layers.time;
  }

  /** Closes all layers. Those that are added next may have these steps. `step`: the first one shown. */
  setTime(time: SceneTime | null, step = 0): void {
    this.#layers.setTime(time, step);
  }

  /** In the order in which they were added, unless they were moved. */
  get layers(): readonly Layer[] {
    return this.#layers.list.listed;
  }

  /** Lists a layer at this index of `layers`. The picture does not change. Throws a RangeError. */
  moveLayer(layer: Layer, index: number): void {
    this.#layers.move(layer, index);
  }

  /** Changes `ViewerOptions.sampleBudget`, also of the layers that are open. */
  setSampleBudget(samples: number): void {
    this.#layers.setSampleBudget(samples);
  }

  /** Retries at once: requests that wait for their next attempt, and parts that have failed. */
  retry(): void {
    this.#layers.retry();
  }

  /** Closes all layers: ends their requests, and frees their memory. The canvas keeps its picture. */
  close(): void {
    this.#layers.setTime(null);
  }

  /** Closes all layers and frees everything. The viewer must not be used afterwards. */
  dispose(): void {
    if (this.#life.isEnded) return;
    this.#life.end();
    this.close();
    this.#scheduler?.stop();
    this.#layers.dispose();
    this.#size.stop();
    this.#detachControls();
    this.#life.destroy();
    this.removeListeners();
  }

  get info(): StoreInfo | null {
    return this.#layers.list.firstInfo;
  }

  get surfaces(): readonly Surface[] {
    return this.#layers.firstSurfaces;
  }

  /** Shows these isosurfaces. The next frame draws their resident samples. */
  setSurfaces(surfaces: readonly Surface[]): void {
    this.#layers.firstSurfaces = surfaces;
  }

  /** Changes the isovalues and keeps the colours. Additional surfaces get the colour of the first. */
  setIsovalues(isovalues: readonly number[]): void {
    this.setSurfaces(withIsovalues(this.surfaces, isovalues));
  }

  /** StreamSession.bytesOf; undefined while the first layer is not open, or hidden. */
  bytesOf(isovalue: number): number | undefined {
    return this.#layers.list.firstSession?.bytesOf(isovalue);
  }

  /** StreamSession.access; undefined while the first layer is not open, or hidden. */
  get storeAccess(): StoreAccess | undefined {
    return this.#layers.list.firstSession?.access;
  }

  /** StreamSession.quantizedIsovalue; undefined while the first layer is not open, or hidden. */
  quantizedIsovalue(isovalue: number): number | undefined {
    return this.#layers.list.firstSession?.quantizedIsovalue(isovalue);
  }

  /** StreamSession.fieldRange of the first layer that shows a field. */
  get fieldRange(): [number, number] | undefined {
    return this.#layers.list.fieldSession?.fieldRange;
  }

  /** StreamSession.fieldHistogram of the first layer that shows a field. */
  get fieldHistogram(): Bins | undefined {
    return this.#layers.list.fieldSession?.fieldHistogram;
  }

  get look(): Readonly<Look> {
    return this.#settings.look;
  }

  setLook({ field, ...change }: LookChange): void {
    const shown = field ? usableField({ ...defaultLook.field, ...field }) : this.look.field;
    this.#settings.look = { ...this.look, ...change, field: shown };
    this.#layers.applySettings();
    // Dragging a slider counts as motion: otherwise pictures with and without occlusion would
    // alternate.
    this.#scheduler?.onCameraChange();
  }

  /** What colours mean; null without a volume, or if surfaces have their own ones and there are no slices. */
  get legend(): Legend | null {
    const { renderer } = this.#life;
    const shown = this.#layers.list.fieldSession?.shownField ?? null;
    return (
      renderer && this.info && this.#settings.legend(renderer, this.info, shown, this.#categories)
    );
  }

  /** Those of the shown field around the drawn surfaces, by value; null if its values are no labels. */
  get #categories(): Category[] | null {
    const { categories, labels } = this.#layers.list;
    return categories.length > 0 ? categories.filter(({ value }) => labels.has(value)) : null;
  }

  get clip(): Clip {
    return this.#settings.clip;
  }

  setClip(clip: Clip): void {
    this.#settings.clip = clip;
    this.#life.renderer?.picture.setClip(clip);
    this.#sceneChanged();
  }

  get slices(): Slices {
    return this.#settings.slices;
  }

  setSlices(slices: Slices): void {
    this.#settings.slices = slices;
    this.#layers.applySettings();
    this.#sceneChanged();
  }

  /** The view may need other cells, or other cells may be visible. */
  #sceneChanged(): void {
    this.#layers.pictureChanged();
    this.#scheduler?.onCameraChange();
  }

  /** Null until a volume is open. */
  get camera(): Camera | null {
    return this.#camera.camera;
  }

  /**
   * Sets the camera. Distance and angles are limited to what can be drawn. If a number is not finite
   * or the target is too far from the volume, the default camera is used.
   */
  setCamera(camera: Camera): void {
    this.#camera.set(camera);
  }

  /**
   * World to clip space for a picture of this size: 4 × 4, column by column. Null until a volume is
   * open. `camera`: by default the present one.
   */
  viewProjection(width: number, height: number, camera?: Camera): Float64Array | null {
    return this.#camera.viewProjection(width, height, camera);
  }

  /** The first view, which shows all layers whole. Null until a volume is open. */
  get wholeView(): Camera | null {
    return this.#camera.whole;
  }

  /** Returns to the first view of the volume. */
  reset(): void {
    if (this.wholeView) this.setCamera(this.wholeView);
  }

  /** Changes between perspective and parallel rays. Objects at the target keep their size. */
  setProjection(projection: Projection): void {
    if (this.camera) this.setCamera({ ...this.camera, projection });
  }

  orbit(rightDegrees: number, upDegrees: number): void {
    this.#camera.orbit(rightDegrees, upDegrees);
  }

  pan(rightPx: number, downPx: number): void {
    this.#camera.pan(rightPx, downPx);
  }

  zoom(factor: number, at: { x: number; y: number } = { x: 0, y: 0 }): void {
    this.#camera.zoom(factor, at);
  }

  /**
   * The nearest surface, or value of a slice, at a position on the canvas (CSS pixels from its
   * upper left corner). For a surface: the ray's first intersection with the trilinear function of
   * a visible cell. Undefined if there is none, or no picture. `toNext` considers only visible
   * cells, so surfaces in occluded regions may be left out.
   */
  pick(x: number, y: number): SurfacePoint | undefined {
    const { canvas, camera } = this;
    if (!camera) return undefined;
    return pickedPoint(this.#life, this.#layers.list, canvas, camera, x, y);
  }

  turnLight(rightDegrees: number, upDegrees: number): void {
    const light = turnedLight(this.look.light, rightDegrees, upDegrees);
    this.setLook({ light });
    this.emit("light", light);
  }

  /**
   * The present picture, at the canvas's resolution. smooth: draws several times to smooth edges,
   * even if this takes long. transparent: without the background.
   */
  screenshot(options: { smooth?: boolean; transparent?: boolean } = {}): Promise<Blob> {
    return this.#pictures.screenshot(options);
  }

  /**
   * Prepares a picture of any size and view: streams the data that it needs (see `isBusy`), and
   * shows its view in the canvas. Null: returns to the canvas's view.
   */
  preparePicture(view: PictureView | null): void {
    this.#pictures.prepare(view);
  }

  /**
   * The data still missing for the present view, of all visible layers; null before the first
   * report.
   */
  get progress(): Progress | null {
    return this.#layers.progress;
  }

  /**
   * Begins the prepared picture, of at most 16384 × 16384 pixels. It is drawn in parts with smooth
   * edges, from the resident samples. Nothing else is drawn until its `end`. Throws a RendererError.
   */
  beginPicture(options: PartsOptions = {}): PictureInParts {
    return this.#pictures.begin(options);
  }

  /** Whether the picture will change without further calls: a volume, data or a finer picture is pending. */
  get isBusy(): boolean {
    return this.#isBusy;
  }

  /** Whether smooth edges and shadows are left out of the picture at rest, because this device draws slowly. */
  get isQuick(): boolean {
    return !this.#isBusy && this.#scheduler?.canRefine === true;
  }

  #showBusy(): void {
    const isWaiting = this.#layers.isWaiting || this.#life.isContextLost;
    const isDrawing = isWaiting || this.#sliceArrivals.isBusy || this.#scheduler?.isBusy;
    const isBusy = this.#layers.list.hasAny && isDrawing !== false;
    if (isBusy === this.#isBusy) return;
    this.#isBusy = isBusy;
    this.emit("busy", isBusy);
  }

  #schedule(renderer: RendererModule): void {
    this.#scheduler?.stop();
    this.#scheduler = new FrameScheduler(this.canvas, renderer, {
      scene: () => this.#pictures.scene(() => this.#layers.shown()),
      missingLayers: () => this.#layers.list.missing,
      guard: (action) => this.#life.guard(action),
      checkGpu: (uploads) => this.#layers.checkGpu(uploads),
      viewed: (...view) => this.#layers.viewed(...view),
      isContextLost: () => this.#life.isContextLost,
      fitCanvas: () => this.#size.fit(),
      drawn: (report) => {
        this.emit("frame", report);
        this.#layers.drawn();
      },
      busyChanged: () => this.#showBusy(),
    });
  }
}
