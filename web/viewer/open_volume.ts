import type { StoreInfo } from "../core/types.ts";
import { StreamSession } from "../stream/session.ts";
import type { Source } from "../stream/source.ts";
import { type Progress, StreamError, type StreamEvents } from "../stream/types.ts";
import { WorkerPool } from "../stream/worker_pool.ts";
import type { FrameScheduler } from "./frame_scheduler.ts";
import type { PictureSettings } from "./picture_settings.ts";
import { RendererError } from "./renderer_error.ts";
import { abortOf, type RendererLife } from "./renderer_life.ts";
import { compiledRenderer } from "./renderer_program.ts";
import { firstSurface } from "./surfaces.ts";
import type { ViewCamera } from "./view_camera.ts";
import type { OpenOptions, ViewerEvents, ViewerOptions } from "./viewer_events.ts";

/** The functions that an open volume needs from its viewer. */
export interface OpenVolumeHost {
  /** Null before the first renderer. */
  scheduler(): FrameScheduler | null;
  emit<Name extends keyof ViewerEvents>(name: Name, detail: ViewerEvents[Name]): void;
  /** Viewer.close. */
  close(): void;
  /** A volume is being opened, was opened or was closed. */
  busyChanged(): void;
  /** A chunk was added or removed. */
  chunksChanged(): void;
}

/**
 * The volume of a viewer: opens a source, passes the chunks of its stream to the renderer, and opens it
 * again if the renderer or the store was replaced.
 */
export class OpenVolume {
  readonly #options: ViewerOptions;
  readonly #life: RendererLife;
  readonly #settings: PictureSettings;
  readonly #camera: ViewCamera;
  readonly #host: OpenVolumeHost;
  #session: StreamSession | null = null;
  #opening: AbortController | null = null;
  /** The volume's workers, if the viewer has no shared `decoder`. */
  #workers: WorkerPool | null = null;
  #progress: Progress | null = null;
  #sampleBudget: number | undefined;

  constructor(
    options: ViewerOptions,
    life: RendererLife,
    settings: PictureSettings,
    camera: ViewCamera,
    host: OpenVolumeHost,
  ) {
    this.#options = options;
    this.#sampleBudget = options.sampleBudget;
    this.#life = life;
    this.#settings = settings;
    this.#camera = camera;
    this.#host = host;
  }

  /** Null until a volume is open. */
  get session(): StreamSession | null {
    return this.#session;
  }

  get info(): StoreInfo | null {
    return this.#session?.info ?? null;
  }

  /** Whether a volume is being opened, or is open. */
  get isOpening(): boolean {
    return this.#opening !== null;
  }

  /** Viewer.progress. */
  get progress(): Progress | null {
    return this.#progress;
  }

  /** Viewer.prepare. */
  async prepare(): Promise<void> {
    if (!this.#options.decoder) this.#ownWorkers();
    await this.#life.load();
    this.#life.warmUp();
  }

  /** Viewer.setSampleBudget. */
  setSampleBudget(samples: number): void {
    this.#sampleBudget = samples;
    this.#session?.setSampleBudget(samples);
  }

  /** Viewer.open. */
  async open(source: Source, options: OpenOptions = {}): Promise<StoreInfo> {
    if (this.#life.isEnded) throw new RendererError("the viewer was disposed of: make another");
    this.#host.close();
    const opening = new AbortController();
    this.#opening = opening;
    const abort = () => opening.abort(options.signal?.reason);
    if (options.signal?.aborted) abort();
    options.signal?.addEventListener("abort", abort, { once: true });
    opening.signal.addEventListener("abort", () =>
      options.signal?.removeEventListener("abort", abort),
    );
    this.#host.busyChanged();
    try {
      return await this.#openSession(source, options, opening.signal);
    } catch (error) {
      if (this.#opening === opening) this.#host.close();
      // The instance has aborted. The next open() creates another one.
      if (abortOf(error)) this.#life.forget();
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
    const cameraBefore = this.#camera.camera;
    const { renderer, core } = await this.#life.load();
    signal.throwIfAborted();
    if (options.surfaces) this.#settings.surfaces = [...options.surfaces];
    const { targetCellPixels, backgroundBytes } = this.#options;
    const sampleBudget = this.#sampleBudget;
    const firstIsovalues = options.surfaces?.map((surface) => surface.isovalue) ?? [];
    const session = await StreamSession.open(source, core, {
      events: this.#streamEvents(),
      signal,
      decoder,
      ...(firstIsovalues.length > 0 ? { firstIsovalues } : {}),
      ...(sampleBudget ? { sampleBudget } : {}),
      ...(targetCellPixels ? { targetCellPixels } : {}),
      ...(backgroundBytes === undefined ? {} : { backgroundBytes }),
    });
    if (signal.aborted) {
      session.close();
      signal.throwIfAborted();
    }
    this.#session = session;
    const { info } = session;
    if (!options.surfaces) this.#settings.surfaces = [firstSurface(info)];
    this.#life.warmUp();
    renderer.volume.open(info);
    this.#camera.opened(renderer, options.camera, options.projection, cameraBefore);
    this.#settings.apply(renderer, info);
    this.#host.emit("opened", info);
    this.#host.scheduler()?.request();
    return info;
  }

  #streamEvents(): StreamEvents {
    return {
      samples: (id, place, samples, clusters) => {
        // The volume is opened again when the context is restored.
        if (this.#life.isContextLost) return true;
        const isTaken = this.#life.guard((renderer) =>
          renderer.volume.addChunk(id, place, samples, clusters),
        );
        if (isTaken) {
          this.#host.scheduler()?.onUpload(id);
          this.#host.chunksChanged();
        }
        return isTaken || this.#life.isContextLost;
      },
      drop: (id) => {
        this.#life.guard((renderer) => renderer.volume.removeChunk(id));
        this.#host.chunksChanged();
      },
      visible: (ids, regions) => {
        this.#life.guard((renderer) => renderer.volume.setVisible(ids, regions));
        this.#host.scheduler()?.onVisibleChange();
      },
      testOcclusion: () => this.#host.scheduler()?.request(),
      progress: (progress) => {
        this.#host.scheduler()?.onProgress(progress);
        this.#progress = progress;
        this.#host.emit("progress", progress);
      },
      error: (error) => {
        // Streaming uses the core of the renderer's instance.
        const abort = abortOf(error);
        if (abort) this.#life.replace(abort);
        else this.#host.emit("error", error);
      },
      replaced: () => void this.#openReplacement(),
    };
  }

  /** Ends the volume's requests, and frees its memory. */
  close(): void {
    this.#opening?.abort(
      new DOMException("the volume was closed, or another was opened", "AbortError"),
    );
    this.#opening = null;
    this.#session?.close();
    this.#session = null;
  }

  /** Ends the workers as well. */
  dispose(): void {
    this.close();
    this.#workers?.close();
  }

  #ownWorkers(): WorkerPool {
    this.#workers ??= new WorkerPool({ renderer: compiledRenderer() });
    return this.#workers;
  }

  /** Checks that the uploads of these chunks, and all before, have succeeded. */
  checkGpu(ids: readonly number[]): void {
    this.#life.guard((renderer) => {
      try {
        renderer.checkGpu();
      } catch (error) {
        if (!(error instanceof RendererError) || error.kind !== "out-of-memory") throw error;
        this.#session?.rejectUploads(ids, error.message);
      }
    });
  }

  /** Opens the volume that is now at the source's address, with the present view. */
  async reopen(): Promise<StoreInfo | undefined> {
    const source = this.#session?.source;
    if (!source) return undefined;
    const options: OpenOptions = {};
    if (this.#settings.surfaces.length > 0) options.surfaces = this.#settings.surfaces;
    if (this.#camera.camera) options.camera = this.#camera.camera;
    source.forget();
    try {
      return await this.open(source, options);
    } catch (error) {
      if (error instanceof StreamError || error instanceof RendererError)
        this.#host.emit("error", error);
      return undefined;
    }
  }

  async #openReplacement(): Promise<void> {
    const before = this.info;
    const info = await this.reopen();
    if (!info) return;
    // In another grid, the camera might not look at the volume.
    const { whole } = this.#camera;
    if (whole && !(before && isSameGrid(before, info))) this.#camera.set(whole);
    this.#host.emit("replaced", info);
  }
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
