import type { StoreInfo } from "../core/types.ts";
import { defaultSampleBudget } from "../stream/device.ts";
import type { Source } from "../stream/source.ts";
import type { Progress, StreamError } from "../stream/types.ts";
import type { FrameScheduler } from "./frame_scheduler.ts";
import type { Upload } from "./frame_scheduler_host.ts";
import type { Layer, LayerOptions, LayerProperty } from "./layer.ts";
import { LayerChanges } from "./layer_changes.ts";
import { type LayerEntry, LayerList, placedOf, volumesOf } from "./layer_list.ts";
import { LayerMaker, type LayerMakerHost } from "./layer_maker.ts";
import { LayerReopening } from "./layer_reopening.ts";
import { LayerSessions } from "./layer_sessions.ts";
import type { StepSources } from "./layer_steps.ts";
import { LayerVolumes } from "./layer_volumes.ts";
import type { OpenVolume } from "./open_volume.ts";
import { PictureProgress } from "./picture_progress.ts";
import type { PictureSettings } from "./picture_settings.ts";
import { RendererError } from "./renderer_error.ts";
import { abortOf, type RendererLife } from "./renderer_life.ts";
import type { RendererModule } from "./renderer_module.ts";
import { SampleBudget } from "./sample_budget.ts";
import { isStreaming, type SceneLayer } from "./scene.ts";
import { Series, type SeriesHost } from "./series.ts";
import { firstSurface } from "./surfaces.ts";
import type { SceneTime, Time } from "./time.ts";
import type { PictureSize, Surface } from "./types.ts";
import type { ViewCamera } from "./view_camera.ts";
import type { AddLayerOptions, OpenOptions, ViewerEvents, ViewerOptions } from "./viewer_events.ts";

/** The functions that the list of layers needs from its viewer. */
export interface LayersHost {
  /** Null before the first renderer. */
  scheduler(): FrameScheduler | null;
  emit<Name extends keyof ViewerEvents>(name: Name, detail: ViewerEvents[Name]): void;
  /** The present picture ends: the next one is unrelated to it. */
  pictureEnds(): void;
  /** A layer is being opened, was opened or was closed. */
  busyChanged(): void;
  /** A chunk of the first layer was added or removed. */
  chunksChanged(): void;
}

/**
 * The layers of a viewer: opens their stores, passes them on to the renderer, and divides the sample
 * budget, the workers and the requests among them.
 */
export class Layers {
  readonly list = new LayerList();
  readonly #sessions: LayerSessions;
  readonly #life: RendererLife;
  readonly #settings: PictureSettings;
  readonly #camera: ViewCamera;
  readonly #host: LayersHost;
  readonly #maker: LayerMaker;
  readonly #samples: SampleBudget;
  readonly #changes: LayerChanges;
  readonly #progress: PictureProgress;
  /** The surfaces for the first layer, while there is no layer. */
  #surfacesBefore: readonly Surface[] = [];
  readonly #volumes = new LayerVolumes(this.list);
  readonly #reopening: LayerReopening;
  #series: Series | null = null;
  #isChangingParts = false;

  constructor(
    options: ViewerOptions,
    life: RendererLife,
    settings: PictureSettings,
    camera: ViewCamera,
    host: LayersHost,
  ) {
    this.#sessions = new LayerSessions(options);
    this.#samples = new SampleBudget(options.sampleBudget || defaultSampleBudget(), this.list);
    this.#changes = new LayerChanges(this.list, () => this.#samples.share());
    this.#progress = new PictureProgress(this.list, this.#samples, (progress) => {
      host.scheduler()?.onProgress(progress);
      host.emit("progress", progress);
    });
    this.#life = life;
    this.#settings = settings;
    this.#camera = camera;
    this.#host = host;
    this.#maker = new LayerMaker(this.#makerHost());
    this.#reopening = new LayerReopening(this.list, life, camera, host, {
      open: (entry) => this.#openEntry(entry),
      failed: (entry, error, isFirst) => this.#failed(entry, error, isFirst),
    });
  }

  get firstSurfaces(): readonly Surface[] {
    return this.list.first?.layer.surfaces ?? this.#surfacesBefore;
  }

  set firstSurfaces(surfaces: readonly Surface[]) {
    if (this.list.first) this.list.first.layer.surfaces = surfaces;
    else this.#surfacesBefore = [...surfaces];
  }

  /** Viewer.progress. */
  get progress(): Progress | null {
    return this.#progress.progress;
  }

  /** Viewer.prepare. */
  async prepare(): Promise<void> {
    void this.#sessions.decoder;
    await this.#life.load();
    this.#life.warmUp();
  }

  /** Viewer.open. */
  async open(source: Source, options: OpenOptions): Promise<StoreInfo> {
    this.#requireLife();
    this.setTime(null);
    const { camera, projection, signal, surfaces } = options;
    const view = { ...(camera ? { camera } : {}), ...(projection ? { projection } : {}) };
    const entry = this.#enter(source, surfaces ? { surfaces } : {}, view);
    this.#host.busyChanged();
    const info = await this.#openEntry(entry, signal);
    this.#announce(entry);
    this.#host.emit("opened", info);
    return info;
  }

  /** Viewer.addLayer. */
  async add(source: Source | StepSources, options: AddLayerOptions): Promise<Layer> {
    this.#requireLife();
    const entry = this.#enter(source, options, null);
    this.#host.busyChanged();
    if (entry.layer.visible) {
      this.#progress.update();
      await this.#openEntry(entry, options.signal);
    }
    this.#announce(entry);
    return entry.layer;
  }

  #requireLife(): void {
    if (this.#life.isEnded) throw new RendererError("the viewer was disposed of: make another");
  }

  #enter(
    source: Source | StepSources,
    options: LayerOptions,
    view: LayerEntry["view"],
  ): LayerEntry {
    const hasSurfaces = options.surfaces !== undefined;
    const surfaces = options.surfaces ?? (this.list.first ? [] : this.#surfacesBefore);
    const own = { ...options, surfaces };
    const entry = this.#maker.make(source, own, view, hasSurfaces, this.#series);
    this.list.add(entry);
    return entry;
  }

  #makerHost(): LayerMakerHost {
    return {
      life: this.#life,
      scheduler: () => this.#host.scheduler(),
      startWorkers: () => void this.#sessions.decoder,
      sessionOptions: (entry, volume) => this.#sessionOptions(entry, volume),
      changed: (entry, property) => this.#changed(entry, property),
      remove: (entry) => this.#remove(entry),
      opened: (...opened) => this.#opened(...opened),
      chunksChanged: (volume) => volume === this.list.first?.volume && this.#host.chunksChanged(),
      fieldOpened: () => this.applySettings(),
      visibleChanged: (volume) => {
        this.#host.scheduler()?.onVisibleChange();
        this.#changes.visible(volume);
      },
      progressChanged: () => this.#progress.layerChanged(),
      failed: (entry, error) => this.#failed(entry, error),
      replaced: (entry) => void this.#reopening.replaced(entry),
    };
  }

  #announce(entry: LayerEntry): void {
    if (entry.isListed) return;
    entry.isListed = true;
    this.#host.emit("layeradd", entry.layer);
  }

  /** Opens a layer's store. If this fails, removes the layer. */
  async #openEntry(entry: LayerEntry, signal?: AbortSignal): Promise<StoreInfo> {
    const { volume } = entry;
    entry.cameraBefore = this.#camera.camera;
    try {
      return await volume.open(signal);
    } catch (error) {
      const abort = abortOf(error);
      // The instance has aborted. A new instance opens the other layers; without any, the next open() creates it.
      if (abort && this.list.sessions.length > 0) this.#life.replace(abort);
      else if (abort) this.#life.forget();
      if (this.list.has(entry) && !volume.session) this.#remove(entry);
      throw error;
    }
  }

  #sessionOptions(entry: LayerEntry, volume: OpenVolume) {
    if (volume === entry.volume) entry.samples = this.#samples.shareOf(entry);
    const samples = entry.steps ? this.#series?.samplesOf(entry, volume) : undefined;
    return this.#sessions.optionsOf(entry, samples ?? entry.samples, this.list.entries.length);
  }

  #opened(entry: LayerEntry, volume: OpenVolume, renderer: RendererModule, info: StoreInfo): void {
    if (!entry.hasSurfaces) entry.layer.surfaces = [firstSurface(info)];
    entry.hasSurfaces = true;
    this.#volumes.opened(entry, volume, renderer);
    volume.showField(this.#settings.shownField);
    if (volume !== entry.volume) return;
    const view = entry.view ?? (this.#camera.camera ? null : {});
    entry.view = null;
    if (view) this.#camera.opened(renderer, view.camera, view.projection, entry.cameraBefore);
    // The range of a field without one in the look is that of the first layer with the field.
    if (entry === this.list.first || this.#settings.shownField !== null) this.applySettings();
    this.#changes.opened();
    this.#host.scheduler()?.request();
  }

  /** Look, clipping and slices refer to the first layer. */
  applySettings(): void {
    const { renderer } = this.#life;
    if (!renderer) return;
    const { shownField } = this.#settings;
    const { firstPlaced, firstNumber } = this.list;
    this.#settings.apply(
      renderer,
      firstPlaced,
      firstNumber,
      this.list.fieldNamed(shownField),
      this.list.categories,
    );
    for (const volume of this.list.entries.flatMap(volumesOf)) volume.showField(shownField);
  }

  /** `opacity`: of the background. */
  applyLook(renderer: RendererModule, opacity: number): void {
    const field = this.list.fieldNamed(this.#settings.shownField);
    this.#settings.applyLook(renderer, this.list.firstPlaced, field, opacity);
  }

  #changed(entry: LayerEntry, property: LayerProperty): void {
    if (!this.list.has(entry)) return;
    const { layer, volume } = entry;
    if (property === "surfaces" && !entry.hasSurfaces) {
      // They follow from the store, which has just been opened.
      if (volume.info) return;
      entry.hasSurfaces = !layer.visible;
    }
    if (property === "visible") this.#visibilityChanged(entry);
    const info = placedOf(entry);
    const isShown = property !== "name" && property !== "group";
    if (info && isShown) {
      this.#life.guard((renderer) => {
        this.#volumes.applySurfaces(entry, renderer);
        if (property !== "transform") return;
        this.#volumes.move(entry, renderer);
        if (entry === this.list.first) this.applySettings();
      });
    }
    if (isShown) {
      this.pictureChanged();
      this.#samples.share();
      this.#series?.changed();
      this.#host.scheduler()?.onCameraChange();
    }
    if (entry.isListed) this.#host.emit("layerchange", { layer, property });
    this.#changeParts(layer, property);
  }

  /** Applies a change of a layer to the other parts of its volume. */
  #changeParts(layer: Layer, property: LayerProperty): void {
    if (this.#isChangingParts) return;
    this.#isChangingParts = true;
    try {
      for (const { layer: part } of this.list.entries) {
        if (part === layer || !part.sharesVolumeWith(layer)) continue;
        if (property === "surfaces") part.surfaces = layer.surfaces;
        else if (property === "visible") part.visible = layer.visible;
        else if (property === "transform") part.transform = layer.transform;
      }
    } finally {
      this.#isChangingParts = false;
    }
  }

  /** Viewer.moveLayer. */
  move(layer: Layer, index: number): void {
    if (this.list.move(layer, index)) this.#host.emit("layermove", { layer, index });
  }

  #visibilityChanged(entry: LayerEntry): void {
    const { layer, volume } = entry;
    if (layer.visible) {
      void this.#reopening.show(entry);
    } else {
      volume.rest();
      this.#series?.closeOthers(entry);
      this.#progress.update();
    }
    this.#host.busyChanged();
  }

  /** The view needs other cells, or shows others: surfaces, clipping or slices have changed. */
  pictureChanged(): void {
    for (const session of this.list.sessions) session.sceneChanged();
  }

  #failed(
    entry: LayerEntry,
    error: StreamError | RendererError,
    isFirst = entry === this.list.first,
  ): void {
    if (isFirst) this.#host.emit("error", error);
    else this.#host.emit("layererror", { layer: entry.layer, error });
  }

  #remove(entry: LayerEntry): void {
    if (!this.list.has(entry)) return;
    if (this.list.entries.length === 1) {
      this.close();
      return;
    }
    const wasFirst = entry === this.list.first;
    this.list.remove(entry);
    const volumes = volumesOf(entry);
    for (const volume of volumes) volume.close();
    this.#volumes.closed();
    this.#life.guard((renderer) => {
      this.#volumes.remove(volumes, renderer);
      if (wasFirst) this.applySettings();
    });
    this.pictureChanged();
    this.#samples.share();
    this.#progress.update();
    this.#host.scheduler()?.onCameraChange();
    this.#host.busyChanged();
    if (entry.isListed) this.#host.emit("layerremove", entry.layer);
  }

  /** Viewer.close. The renderer keeps the last grids, so that the camera can move until the next grids are known. */
  close(): void {
    this.#host.pictureEnds();
    this.#changes.cancel();
    this.#progress.cancel();
    this.#surfacesBefore = this.firstSurfaces;
    const { entries } = this.list;
    this.list.clear();
    for (const volume of entries.flatMap(volumesOf)) volume.close();
    this.#volumes.closed();
    this.#host.busyChanged();
    for (const { layer, isListed } of entries) {
      if (isListed) this.#host.emit("layerremove", layer);
    }
  }

  /** Ends the workers as well. */
  dispose(): void {
    this.setTime(null);
    this.#sessions.close();
  }

  retry(): void {
    for (const session of this.list.sessions) session.retry();
    this.#series?.retry();
  }

  /** Viewer.setSampleBudget. */
  setSampleBudget(samples: number): void {
    this.#samples.set(samples);
  }

  /** The view that is drawn: world to clip space, column by column. `isMoving`: not at rest. */
  viewed(viewProjection: Float64Array, viewport: PictureSize, isMoving: boolean): void {
    if (!isMoving) this.#samples.viewed(viewProjection);
    this.#series?.viewed(viewProjection, viewport);
  }

  /** Whether something that is to be shown is being opened. */
  get isWaiting(): boolean {
    const isBuffering = this.#series?.time.isBuffering ?? false;
    return isBuffering || this.list.isWaiting || this.#progress.isPending;
  }

  /** Viewer.time. */
  get time(): Time | null {
    return this.#series?.time ?? null;
  }

  /** Viewer.setTime. */
  setTime(time: SceneTime | null, step = 0): void {
    this.close();
    const before = this.#series;
    before?.close();
    this.#series = time && new Series(time, step, this.#seriesHost());
    if (before || time) this.#host.emit("time", this.time);
  }

  #seriesHost(): SeriesHost {
    return {
      list: this.list,
      life: this.#life,
      volumes: this.#volumes,
      shownField: () => this.#settings.shownField,
      stepShown: () => {
        this.#life.guard(() => this.applySettings());
        this.pictureChanged();
        this.#progress.update();
        this.#host.scheduler()?.onCameraChange();
      },
      busyChanged: () => this.#host.busyChanged(),
      failed: (entry, error) => this.#failed(entry, error),
      isComplete: () => this.progress !== null && !isStreaming(this.progress),
    };
  }

  /** A frame was drawn. */
  drawn(): void {
    this.#series?.drawn();
  }

  /** The layers that are drawn. */
  shown(): SceneLayer[] {
    return this.list.shown(this.#series?.shownCellPixels);
  }

  /** Checks that these uploads, and all before, have succeeded. */
  checkGpu(uploads: readonly Upload[]): void {
    this.#life.guard((renderer) => this.#volumes.checkGpu(renderer, uploads));
  }

  /** Opens all volumes again with the present view, because their samples are lost. */
  async reopen(): Promise<void> {
    for (const entry of this.list.entries) this.#series?.closeOthers(entry);
    await this.#reopening.all();
  }
}
