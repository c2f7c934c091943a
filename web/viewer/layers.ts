import type { StoreInfo } from "../core/types.ts";
import type { Decoder } from "../stream/decoder.ts";
import { defaultSampleBudget } from "../stream/device.ts";
import { RequestLimit } from "../stream/request_limit.ts";
import type { Source } from "../stream/source.ts";
import type { Progress, StreamError } from "../stream/types.ts";
import { WorkerPool } from "../stream/worker_pool.ts";
import type { FrameScheduler, Upload } from "./frame_scheduler.ts";
import { Layer, type LayerOptions, type LayerProperty } from "./layer.ts";
import { type LayerEntry, LayerList, placedOf } from "./layer_list.ts";
import { isReported, LayerReopening } from "./layer_reopening.ts";
import { LayerVolumes } from "./layer_volumes.ts";
import { openingProgress, progressOfLayers } from "./layers_progress.ts";
import { OpenVolume } from "./open_volume.ts";
import type { PictureSettings } from "./picture_settings.ts";
import { RendererError } from "./renderer_error.ts";
import { abortOf, type RendererLife } from "./renderer_life.ts";
import type { RendererModule } from "./renderer_module.ts";
import { compiledRenderer } from "./renderer_program.ts";
import { SampleBudget } from "./sample_budget.ts";
import { firstSurface } from "./surfaces.ts";
import type { Surface } from "./types.ts";
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
  readonly #options: ViewerOptions;
  readonly #life: RendererLife;
  readonly #settings: PictureSettings;
  readonly #camera: ViewCamera;
  readonly #host: LayersHost;
  #nextId = 0;
  /** The viewer's own workers, if it has no `decoder` of others. */
  #workers: WorkerPool | null = null;
  readonly #requests = new RequestLimit();
  readonly #samples: SampleBudget;
  #progress: Progress | null = null;
  /** Those of the first layer, while there is none. */
  #surfacesBefore: readonly Surface[] = [];
  readonly #volumes = new LayerVolumes(this.list);
  readonly #reopening: LayerReopening;

  constructor(
    options: ViewerOptions,
    life: RendererLife,
    settings: PictureSettings,
    camera: ViewCamera,
    host: LayersHost,
  ) {
    this.#options = options;
    this.#samples = new SampleBudget(options.sampleBudget || defaultSampleBudget(), this.list);
    this.#life = life;
    this.#settings = settings;
    this.#camera = camera;
    this.#host = host;
    this.#reopening = new LayerReopening(this.list, camera, host, {
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
    return this.#progress;
  }

  /** Viewer.prepare. */
  async prepare(): Promise<void> {
    this.#decoder();
    await this.#life.load();
    this.#life.warmUp();
  }

  #decoder(): Decoder {
    if (this.#options.decoder) return this.#options.decoder;
    this.#workers ??= new WorkerPool({ renderer: compiledRenderer() });
    return this.#workers;
  }

  /** Viewer.open. */
  async open(source: Source, options: OpenOptions): Promise<StoreInfo> {
    this.#requireLife();
    this.close();
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
  async add(source: Source, options: AddLayerOptions): Promise<Layer> {
    this.#requireLife();
    const entry = this.#enter(source, options, null);
    this.#host.busyChanged();
    if (entry.layer.visible) {
      this.#progressChanged();
      await this.#openEntry(entry, options.signal);
    }
    this.#announce(entry);
    return entry.layer;
  }

  #requireLife(): void {
    if (this.#life.isEnded) throw new RendererError("the viewer was disposed of: make another");
  }

  #enter(source: Source, options: LayerOptions, view: LayerEntry["view"]): LayerEntry {
    const surfaces = options.surfaces ?? (this.list.first ? [] : this.#surfacesBefore);
    const layer = new Layer(
      this.#nextId++,
      source,
      { ...options, surfaces },
      {
        info: () => entry.volume.info,
        progress: () => entry.volume.progress,
        session: () => entry.volume.session,
        changed: (property) => this.#changed(entry, property),
        remove: () => this.#remove(entry),
      },
    );
    const volume = new OpenVolume(layer.id, source, this.#life, {
      sessionOptions: () => this.#sessionOptions(entry),
      opened: (renderer, info) => this.#opened(entry, renderer, info),
      uploaded: (id) => this.#host.scheduler()?.onUpload({ volume: layer.id, id }),
      chunksChanged: () => entry === this.list.first && this.#host.chunksChanged(),
      visibleChanged: () => {
        this.#host.scheduler()?.onVisibleChange();
        for (const other of this.list.sessions) {
          if (other !== volume.session) other.otherPictureChanged();
        }
      },
      testOcclusion: () => this.#host.scheduler()?.request(),
      progressChanged: () => this.#progressChanged(),
      failed: (error) => this.#failed(entry, error),
      replaced: () => void this.#reopening.replaced(entry),
    });
    const hasSurfaces = options.surfaces !== undefined;
    const entry: LayerEntry = {
      layer,
      volume,
      isListed: false,
      hasSurfaces,
      view,
      cameraBefore: null,
      samples: 0,
    };
    this.list.add(entry);
    return entry;
  }

  #announce(entry: LayerEntry): void {
    if (entry.isListed) return;
    entry.isListed = true;
    this.#host.emit("layeradd", entry.layer);
  }

  /** Opens a layer's store. After a failure the layer is gone. */
  async #openEntry(entry: LayerEntry, signal?: AbortSignal): Promise<StoreInfo> {
    const { volume } = entry;
    entry.cameraBefore = this.#camera.camera;
    try {
      return await volume.open(signal);
    } catch (error) {
      const abort = abortOf(error);
      // The instance has aborted. The others are opened with another one, or the next open() creates it.
      if (abort && this.list.sessions.length > 0) this.#life.replace(abort);
      else if (abort) this.#life.forget();
      if (this.list.has(entry) && !volume.session) this.#remove(entry);
      throw error;
    }
  }

  #sessionOptions(entry: LayerEntry) {
    const { targetCellPixels, backgroundBytes } = this.#options;
    entry.samples = this.#samples.shareOf(entry);
    const { surfaces } = entry.layer;
    const firstIsovalues = entry.hasSurfaces ? surfaces.map(({ isovalue }) => isovalue) : [];
    return {
      decoder: this.#decoder(),
      requests: this.#requests,
      sampleBudget: entry.samples,
      ...(firstIsovalues.length > 0 ? { firstIsovalues } : {}),
      ...(targetCellPixels ? { targetCellPixels } : {}),
      ...(backgroundBytes === undefined ? {} : { backgroundBytes }),
    };
  }

  #opened(entry: LayerEntry, renderer: RendererModule, info: StoreInfo): void {
    if (!entry.hasSurfaces) entry.layer.surfaces = [firstSurface(info)];
    entry.hasSurfaces = true;
    this.#volumes.opened(entry, renderer);
    const view = entry.view ?? (this.#camera.camera ? null : {});
    entry.view = null;
    if (view) this.#camera.opened(renderer, view.camera, view.projection, entry.cameraBefore);
    if (entry === this.list.first) this.#applySettings(renderer);
    for (const session of this.list.sessions) {
      if (session !== entry.volume.session) session.sceneChanged();
    }
    this.#samples.share();
    this.#host.scheduler()?.request();
  }

  #applySettings(renderer: RendererModule): void {
    this.#settings.apply(renderer, this.list.firstPlaced, this.list.firstNumber);
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
        renderer.volume(layer.id).move(info);
        if (entry === this.list.first) this.#applySettings(renderer);
      });
    }
    if (isShown) {
      this.pictureChanged();
      this.#samples.share();
      this.#host.scheduler()?.onCameraChange();
    }
    if (entry.isListed) this.#host.emit("layerchange", { layer, property });
  }

  /** Viewer.moveLayer. */
  move(layer: Layer, index: number): void {
    if (this.list.move(layer, index)) this.#host.emit("layermove", { layer, index });
  }

  #visibilityChanged(entry: LayerEntry): void {
    const { layer, volume } = entry;
    if (layer.visible) {
      void this.#show(entry);
    } else {
      volume.rest();
      this.#progressChanged();
    }
    this.#host.busyChanged();
  }

  /** A layer whose store cannot be opened stays hidden. */
  async #show(entry: LayerEntry): Promise<void> {
    try {
      await entry.volume.open();
    } catch (error) {
      const abort = abortOf(error);
      if (abort) this.#life.replace(abort);
      if (!this.list.has(entry) || !entry.layer.visible || entry.volume.session) return;
      if (isReported(error)) this.#failed(entry, error);
      entry.layer.visible = false;
    }
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

  #progressChanged(): void {
    const shown = this.list.entries.filter(({ layer }) => layer.visible);
    const isFirstOpening = shown.length > 0 && shown.every(({ volume }) => !volume.progress);
    if (isFirstOpening) return;
    const parts = shown.map(({ volume }) => volume.progress ?? openingProgress);
    const progress = progressOfLayers(parts, this.#samples.samples);
    this.#progress = progress;
    this.#host.scheduler()?.onProgress(progress);
    this.#host.emit("progress", progress);
  }

  #remove(entry: LayerEntry): void {
    if (!this.list.has(entry)) return;
    if (this.list.entries.length === 1) {
      this.close();
      return;
    }
    const wasFirst = entry === this.list.first;
    this.list.remove(entry);
    entry.volume.close();
    const { renderer } = this.#life;
    if (renderer) {
      this.#volumes.forget(entry, renderer);
      this.#life.guard(() => {
        renderer.volume(entry.layer.id).remove();
        if (wasFirst) this.#applySettings(renderer);
      });
    }
    this.pictureChanged();
    this.#samples.share();
    this.#progressChanged();
    this.#host.scheduler()?.onCameraChange();
    this.#host.busyChanged();
    if (entry.isListed) this.#host.emit("layerremove", entry.layer);
  }

  /** Viewer.close. The renderer keeps the last grids, in which the camera moves until the next are known. */
  close(): void {
    this.#host.pictureEnds();
    this.#surfacesBefore = this.firstSurfaces;
    const { entries } = this.list;
    this.list.clear();
    for (const { volume } of entries) volume.close();
    this.#host.busyChanged();
    for (const { layer, isListed } of entries) {
      if (isListed) this.#host.emit("layerremove", layer);
    }
  }

  /** Ends the workers as well. */
  dispose(): void {
    this.close();
    this.#workers?.close();
  }

  retry(): void {
    for (const session of this.list.sessions) session.retry();
  }

  /** Viewer.setSampleBudget. */
  setSampleBudget(samples: number): void {
    this.#samples.set(samples);
  }

  /** The view that is drawn at rest: world to clip space, column by column. */
  viewed(viewProjection: Float64Array): void {
    this.#samples.viewed(viewProjection);
  }

  /** Checks that these uploads, and all before, have succeeded. */
  checkGpu(uploads: readonly Upload[]): void {
    this.#life.guard((renderer) => {
      try {
        renderer.checkGpu();
      } catch (error) {
        if (!(error instanceof RendererError) || error.kind !== "out-of-memory") throw error;
        for (const { layer, volume } of this.list.entries) {
          const ids = uploads.filter((each) => each.volume === layer.id).map(({ id }) => id);
          if (ids.length > 0) volume.rejectUploads(ids, error);
        }
      }
    });
  }

  /** Opens all volumes again with the present view: their samples are lost. */
  async reopen(): Promise<void> {
    await this.#reopening.all();
  }
}
