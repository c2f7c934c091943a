import type { StoreInfo } from "../core/types.ts";
import type { Decoder } from "../stream/decoder.ts";
import { defaultSampleBudget } from "../stream/device.ts";
import { RequestLimit } from "../stream/request_limit.ts";
import type { StreamSession } from "../stream/session.ts";
import type { Source } from "../stream/source.ts";
import { type Progress, StreamError } from "../stream/types.ts";
import { WorkerPool } from "../stream/worker_pool.ts";
import type { FrameScheduler, Upload } from "./frame_scheduler.ts";
import { Layer, type LayerOptions, type LayerProperty } from "./layer.ts";
import { openingProgress, progressOfLayers } from "./layers_progress.ts";
import { OpenVolume } from "./open_volume.ts";
import type { PictureSettings } from "./picture_settings.ts";
import { RendererError } from "./renderer_error.ts";
import { abortOf, type RendererLife } from "./renderer_life.ts";
import type { RendererModule } from "./renderer_module.ts";
import { compiledRenderer } from "./renderer_program.ts";
import { type SampleNeed, shareSamples } from "./sample_shares.ts";
import { isStreaming, type SceneLayer } from "./scene.ts";
import { firstSurface } from "./surfaces.ts";
import { coverage, placed, viewProjectionOf } from "./transform.ts";
import type { Camera, Surface } from "./types.ts";
import type { ViewCamera } from "./view_camera.ts";
import type { AddLayerOptions, OpenOptions, ViewerEvents, ViewerOptions } from "./viewer_events.ts";

/** Shares of the sample budget that differ less from the present ones are not worth a change. */
const smallestChange = 0.1;

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

interface Entry {
  readonly layer: Layer;
  readonly volume: OpenVolume;
  /** Whether it is among `Layers.listed`. */
  isListed: boolean;
  /** Whether its surfaces were chosen. Otherwise they follow from the store. */
  hasSurfaces: boolean;
  /** The camera to set when the store is open; null: keeps the present one. */
  view: Pick<OpenOptions, "camera" | "projection"> | null;
  /** The camera when the opening began. */
  cameraBefore: Camera | null;
  /** The present share of the sample budget. */
  samples: number;
}

/**
 * The layers of a viewer: opens their stores, passes them on to the renderer, and divides the sample
 * budget, the workers and the requests among them.
 */
export class Layers {
  readonly #options: ViewerOptions;
  readonly #life: RendererLife;
  readonly #settings: PictureSettings;
  readonly #camera: ViewCamera;
  readonly #host: LayersHost;
  /** By `id`, also those that are being opened. */
  #entries: Entry[] = [];
  #nextId = 0;
  /** The viewer's own workers, if it has no `decoder` of others. */
  #workers: WorkerPool | null = null;
  readonly #requests = new RequestLimit();
  #sampleBudget: number;
  #progress: Progress | null = null;
  /** Those of the first layer, while there is none. */
  #surfacesBefore: readonly Surface[] = [];
  /** The volumes that each renderer has. */
  readonly #volumes = new WeakMap<RendererModule, Set<number>>();
  #viewProjection: Float64Array | null = null;

  constructor(
    options: ViewerOptions,
    life: RendererLife,
    settings: PictureSettings,
    camera: ViewCamera,
    host: LayersHost,
  ) {
    this.#options = options;
    this.#sampleBudget = options.sampleBudget || defaultSampleBudget();
    this.#life = life;
    this.#settings = settings;
    this.#camera = camera;
    this.#host = host;
  }

  /** Viewer.layers. */
  get listed(): Layer[] {
    return this.#entries.filter(({ isListed }) => isListed).map(({ layer }) => layer);
  }

  /** The number of the first layer in the renderer. */
  get firstNumber(): number {
    return this.#first?.layer.id ?? 0;
  }

  /** The store of the first layer. Null until it is open. */
  get firstInfo(): StoreInfo | null {
    return this.#first?.volume.info ?? null;
  }

  /** The same, where the layer's transform puts it. */
  get firstPlaced(): StoreInfo | null {
    const first = this.#first;
    return (first && placedOf(first)) ?? null;
  }

  /** Null until the first layer is open, and while it is hidden. */
  get firstSession(): StreamSession | null {
    return this.#first?.volume.session ?? null;
  }

  get firstSurfaces(): readonly Surface[] {
    return this.#first?.layer.surfaces ?? this.#surfacesBefore;
  }

  set firstSurfaces(surfaces: readonly Surface[]) {
    if (this.#first) this.#first.layer.surfaces = surfaces;
    else this.#surfacesBefore = [...surfaces];
  }

  /** Whether a layer is being opened, or is open. */
  get hasAny(): boolean {
    return this.#entries.some(({ layer, volume }) => layer.visible || volume.info !== null);
  }

  /** Whether a visible layer is being opened. */
  get isWaiting(): boolean {
    return this.#entries.some(({ layer, volume }) => layer.visible && !volume.session);
  }

  /** Whether a picture can be drawn: a volume is open, or hidden. */
  get isOpen(): boolean {
    return this.#entries.some(({ layer, volume }) => volume.session || !layer.visible);
  }

  /** Viewer.progress. */
  get progress(): Progress | null {
    return this.#progress;
  }

  get #first(): Entry | undefined {
    return this.#entries[0];
  }

  get #sessions(): StreamSession[] {
    return this.#entries.flatMap(({ volume }) => volume.session ?? []);
  }

  /** The layers that are drawn. */
  shown(): SceneLayer[] {
    return this.#entries.flatMap(({ layer, volume: { session, progress } }) => {
      if (!session) return [];
      const isovalues = layer.surfaces.map((surface) => surface.isovalue);
      const { id: number, transform } = layer;
      const isDone = progress !== null && !isStreaming(progress);
      return [{ number, session, isovalues, transform, isDone }];
    });
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
    this.#list(entry);
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
    this.#list(entry);
    return entry.layer;
  }

  #requireLife(): void {
    if (this.#life.isEnded) throw new RendererError("the viewer was disposed of: make another");
  }

  #enter(source: Source, options: LayerOptions, view: Entry["view"]): Entry {
    const surfaces = options.surfaces ?? (this.#first ? [] : this.#surfacesBefore);
    const layer = new Layer(
      this.#nextId++,
      source,
      { ...options, surfaces },
      {
        info: () => entry.volume.info,
        progress: () => entry.volume.progress,
        changed: (property) => this.#changed(entry, property),
        remove: () => this.#remove(entry),
      },
    );
    const volume = new OpenVolume(layer.id, source, this.#life, {
      sessionOptions: () => this.#sessionOptions(entry),
      opened: (renderer, info) => this.#opened(entry, renderer, info),
      uploaded: (id) => this.#host.scheduler()?.onUpload({ volume: layer.id, id }),
      chunksChanged: () => entry === this.#first && this.#host.chunksChanged(),
      visibleChanged: () => {
        this.#host.scheduler()?.onVisibleChange();
        for (const other of this.#sessions) {
          if (other !== volume.session) other.otherPictureChanged();
        }
      },
      testOcclusion: () => this.#host.scheduler()?.request(),
      progressChanged: () => this.#progressChanged(),
      failed: (error) => this.#failed(entry, error),
      replaced: () => void this.#openReplacement(entry),
    });
    const hasSurfaces = options.surfaces !== undefined;
    const entry: Entry = {
      layer,
      volume,
      isListed: false,
      hasSurfaces,
      view,
      cameraBefore: null,
      samples: 0,
    };
    this.#entries.push(entry);
    return entry;
  }

  #list(entry: Entry): void {
    if (entry.isListed) return;
    entry.isListed = true;
    this.#host.emit("layeradd", entry.layer);
  }

  /** Opens a layer's store. After a failure the layer is gone. */
  async #openEntry(entry: Entry, signal?: AbortSignal): Promise<StoreInfo> {
    const { volume } = entry;
    entry.cameraBefore = this.#camera.camera;
    try {
      return await volume.open(signal);
    } catch (error) {
      const abort = abortOf(error);
      // The instance has aborted. The others are opened with another one, or the next open() creates it.
      if (abort && this.#sessions.length > 0) this.#life.replace(abort);
      else if (abort) this.#life.forget();
      if (this.#entries.includes(entry) && !volume.session) this.#remove(entry);
      throw error;
    }
  }

  #sessionOptions(entry: Entry) {
    const { targetCellPixels, backgroundBytes } = this.#options;
    const needs = this.#entries
      .filter((each) => each === entry || each.layer.visible)
      .map((each) => ({ each, need: this.#need(each) }));
    const shares = shareSamples(
      this.#sampleBudget,
      needs.map(({ need }) => need),
    );
    entry.samples = shares[needs.findIndex(({ each }) => each === entry)] ?? this.#sampleBudget;
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

  #opened(entry: Entry, renderer: RendererModule, info: StoreInfo): void {
    if (!entry.hasSurfaces) entry.layer.surfaces = [firstSurface(info)];
    entry.hasSurfaces = true;
    this.#setVolumes(entry, renderer);
    this.#applySurfaces(entry, renderer);
    const view = entry.view ?? (this.#camera.camera ? null : {});
    entry.view = null;
    if (view) this.#camera.opened(renderer, view.camera, view.projection, entry.cameraBefore);
    if (entry === this.#first) this.#applySettings(renderer);
    for (const session of this.#sessions) {
      if (session !== entry.volume.session) session.sceneChanged();
    }
    this.#share();
    this.#host.scheduler()?.request();
  }

  /** Gives the renderer, which may be another one, the volumes of all layers, and takes all others away. */
  #setVolumes(entry: Entry, renderer: RendererModule): void {
    const present = this.#volumes.get(renderer) ?? new Set<number>();
    this.#volumes.set(renderer, present);
    for (const number of [...present]) {
      if (this.#entries.some(({ layer }) => layer.id === number)) continue;
      renderer.volume(number).remove();
      present.delete(number);
    }
    for (const each of this.#entries) {
      const info = placedOf(each);
      const { id } = each.layer;
      if (!info || (each !== entry && present.has(id))) continue;
      renderer.volume(id).open(info);
      present.add(id);
    }
  }

  #applySurfaces({ layer }: Entry, renderer: RendererModule): void {
    renderer.volume(layer.id).setSurfaces(layer.visible ? layer.surfaces : []);
  }

  #applySettings(renderer: RendererModule): void {
    this.#settings.apply(renderer, this.firstPlaced, this.firstNumber);
  }

  #changed(entry: Entry, property: LayerProperty): void {
    if (!this.#entries.includes(entry)) return;
    const { layer, volume } = entry;
    if (property === "surfaces" && !entry.hasSurfaces) {
      // They follow from the store, which has just been opened.
      if (volume.info) return;
      entry.hasSurfaces = !layer.visible;
    }
    if (property === "visible") this.#visibilityChanged(entry);
    const info = placedOf(entry);
    if (info && property !== "name") {
      this.#life.guard((renderer) => {
        this.#applySurfaces(entry, renderer);
        if (property !== "transform") return;
        renderer.volume(layer.id).move(info);
        if (entry === this.#first) this.#applySettings(renderer);
      });
    }
    if (property !== "name") {
      this.pictureChanged();
      this.#share();
      this.#host.scheduler()?.onCameraChange();
    }
    if (entry.isListed) this.#host.emit("layerchange", { layer, property });
  }

  #visibilityChanged(entry: Entry): void {
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
  async #show(entry: Entry): Promise<void> {
    try {
      await entry.volume.open();
    } catch (error) {
      const abort = abortOf(error);
      if (abort) this.#life.replace(abort);
      if (!this.#entries.includes(entry) || !entry.layer.visible || entry.volume.session) return;
      if (isReported(error)) this.#failed(entry, error);
      entry.layer.visible = false;
    }
  }

  /** The view needs other cells, or shows others: surfaces, clipping or slices have changed. */
  pictureChanged(): void {
    for (const session of this.#sessions) session.sceneChanged();
  }

  #failed(entry: Entry, error: StreamError | RendererError, isFirst = entry === this.#first): void {
    if (isFirst) this.#host.emit("error", error);
    else this.#host.emit("layererror", { layer: entry.layer, error });
  }

  #progressChanged(): void {
    const shown = this.#entries.filter(({ layer }) => layer.visible);
    const isFirstOpening = shown.length > 0 && shown.every(({ volume }) => !volume.progress);
    if (isFirstOpening) return;
    const parts = shown.map(({ volume }) => volume.progress ?? openingProgress);
    const progress = progressOfLayers(parts, this.#sampleBudget);
    this.#progress = progress;
    this.#host.scheduler()?.onProgress(progress);
    this.#host.emit("progress", progress);
  }

  #remove(entry: Entry): void {
    if (!this.#entries.includes(entry)) return;
    if (this.#entries.length === 1) {
      this.close();
      return;
    }
    const wasFirst = entry === this.#first;
    this.#entries = this.#entries.filter((each) => each !== entry);
    entry.volume.close();
    const { renderer } = this.#life;
    if (renderer) {
      this.#volumes.get(renderer)?.delete(entry.layer.id);
      this.#life.guard(() => {
        renderer.volume(entry.layer.id).remove();
        if (wasFirst) this.#applySettings(renderer);
      });
    }
    this.pictureChanged();
    this.#share();
    this.#progressChanged();
    this.#host.scheduler()?.onCameraChange();
    this.#host.busyChanged();
    if (entry.isListed) this.#host.emit("layerremove", entry.layer);
  }

  /** Viewer.close. The renderer keeps the last grids, in which the camera moves until the next are known. */
  close(): void {
    this.#host.pictureEnds();
    this.#surfacesBefore = this.firstSurfaces;
    const entries = this.#entries;
    this.#entries = [];
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
    for (const session of this.#sessions) session.retry();
  }

  /** Viewer.setSampleBudget. */
  setSampleBudget(samples: number): void {
    this.#sampleBudget = samples;
    this.#share(true);
  }

  /** The view that is drawn at rest: layers that cover more of it get more of the sample budget. */
  viewed(viewProjection: Float64Array): void {
    this.#viewProjection = viewProjection;
    if (this.#entries.length > 1) this.#share();
  }

  #need({ layer, volume: { info, session } }: Entry): SampleNeed {
    const view = this.#viewProjection;
    return {
      pinned: session?.pinnedSamples ?? 0,
      coverage: info && view ? coverage(info, viewProjectionOf(view, layer.transform)) : 1,
      surfaces: layer.surfaces.filter(({ opacity }) => opacity > 0).length,
    };
  }

  /** All shares change, or none, so that their sum stays within the budget. */
  #share(isOtherBudget = false): void {
    const sharing = this.#entries.filter(({ volume }) => volume.session);
    const shares = shareSamples(
      this.#sampleBudget,
      sharing.map((entry) => this.#need(entry)),
    );
    const isOther = sharing.some(({ samples }, i) => {
      const change = Math.abs((shares[i] ?? 0) - samples);
      return change > (sharing.length > 1 ? smallestChange * samples : 0);
    });
    if (!isOther && !isOtherBudget) return;
    sharing.forEach((entry, i) => {
      entry.samples = shares[i] ?? 0;
      entry.volume.session?.setSampleBudget(entry.samples);
    });
  }

  /** Checks that these uploads, and all before, have succeeded. */
  checkGpu(uploads: readonly Upload[]): void {
    this.#life.guard((renderer) => {
      try {
        renderer.checkGpu();
      } catch (error) {
        if (!(error instanceof RendererError) || error.kind !== "out-of-memory") throw error;
        for (const { layer, volume } of this.#entries) {
          const ids = uploads.filter((each) => each.volume === layer.id).map(({ id }) => id);
          if (ids.length > 0) volume.rejectUploads(ids, error);
        }
      }
    });
  }

  /** Opens all volumes again with the present view: their samples are lost. */
  async reopen(): Promise<void> {
    const open = this.#entries.filter(({ volume }) => volume.session);
    await Promise.all(open.map((entry) => this.#reopen(entry)));
  }

  /** Opens the volume that is now at the source's address, with the present view. */
  async #reopen(entry: Entry): Promise<StoreInfo | undefined> {
    const { layer, volume } = entry;
    if (!volume.session) return undefined;
    entry.hasSurfaces ||= layer.surfaces.length > 0;
    const { camera } = this.#camera;
    const isFirst = entry === this.#first;
    entry.view = isFirst && camera ? { camera } : null;
    layer.source.forget();
    if (this.#sessions.length === 1) this.#host.pictureEnds();
    const opening = this.#openEntry(entry);
    this.#host.busyChanged();
    try {
      const info = await opening;
      if (isFirst) this.#host.emit("opened", info);
      return info;
    } catch (error) {
      if (isReported(error)) this.#failed(entry, error, isFirst);
      return undefined;
    }
  }

  async #openReplacement(entry: Entry): Promise<void> {
    const before = entry.volume.info;
    const info = await this.#reopen(entry);
    if (!info) return;
    if (entry !== this.#first) {
      this.#host.emit("layerchange", { layer: entry.layer, property: "info" });
      return;
    }
    // In another grid, the camera might not look at the volume.
    const { whole } = this.#camera;
    if (whole && !(before && isSameGrid(before, info))) this.#camera.set(whole);
    this.#host.emit("replaced", info);
  }
}

function placedOf({ layer, volume: { info } }: Entry): StoreInfo | null {
  return info && placed(info, layer.transform);
}

function isReported(error: unknown): error is StreamError | RendererError {
  return error instanceof StreamError || error instanceof RendererError;
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
