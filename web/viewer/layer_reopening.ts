import type { StoreInfo } from "../core/types.ts";
import { StreamError } from "../stream/types.ts";
import type { LayerEntry, LayerList } from "./layer_list.ts";
import type { LayersHost } from "./layers.ts";
import { RendererError } from "./renderer_error.ts";
import { abortOf, type RendererLife } from "./renderer_life.ts";
import { isSameGrid } from "./transform.ts";
import type { ViewCamera } from "./view_camera.ts";

/** The functions that reopening needs from the list of layers. */
export interface LayerReopeningHost {
  /** Opens a layer's store. Rejects if this fails. */
  open(entry: LayerEntry): Promise<StoreInfo>;
  failed(entry: LayerEntry, error: StreamError | RendererError, isFirst: boolean): void;
}

/** Opens layers again, after a lost context or because another store is at the source's address. */
export class LayerReopening {
  readonly #list: LayerList;
  readonly #life: RendererLife;
  readonly #camera: ViewCamera;
  readonly #viewer: Pick<LayersHost, "emit" | "pictureEnds" | "busyChanged">;
  readonly #host: LayerReopeningHost;

  constructor(
    list: LayerList,
    life: RendererLife,
    camera: ViewCamera,
    viewer: Pick<LayersHost, "emit" | "pictureEnds" | "busyChanged">,
    host: LayerReopeningHost,
  ) {
    this.#list = list;
    this.#life = life;
    this.#camera = camera;
    this.#viewer = viewer;
    this.#host = host;
  }

  /** A layer is visible again. If its store cannot be opened, it stays hidden. */
  async show(entry: LayerEntry): Promise<void> {
    const { layer, volume } = entry;
    try {
      await volume.open();
    } catch (error) {
      const abort = abortOf(error);
      if (abort) this.#life.replace(abort);
      const isPresent = this.#list.has(entry) && entry.volume === volume;
      if (!isPresent || !layer.visible || volume.session) return;
      if (isReported(error)) this.#host.failed(entry, error, entry === this.#list.first);
      // Its other steps may be readable.
      if (!entry.steps) layer.visible = false;
    }
  }

  /** Opens all volumes again with the present view, because their samples are lost. */
  async all(): Promise<void> {
    const open = this.#list.entries.filter(({ volume }) => volume.session);
    await Promise.all(open.map((entry) => this.#reopen(entry)));
  }

  /** Opens the volume that is now at the source's address, with the present view. */
  async #reopen(entry: LayerEntry): Promise<StoreInfo | undefined> {
    const { layer, volume } = entry;
    if (!volume.session) return undefined;
    entry.hasSurfaces ||= layer.surfaces.length > 0;
    const { camera } = this.#camera;
    const isFirst = entry === this.#list.first;
    entry.view = isFirst && camera ? { camera } : null;
    layer.source.forget();
    if (this.#list.sessions.length === 1) this.#viewer.pictureEnds();
    const opening = this.#host.open(entry);
    this.#viewer.busyChanged();
    try {
      const info = await opening;
      if (isFirst) this.#viewer.emit("opened", info);
      return info;
    } catch (error) {
      if (isReported(error)) this.#host.failed(entry, error, isFirst);
      return undefined;
    }
  }

  /** Another store is at the source's address. */
  async replaced(entry: LayerEntry): Promise<void> {
    const before = entry.volume.info;
    const info = await this.#reopen(entry);
    if (!info) return;
    if (entry !== this.#list.first) {
      this.#viewer.emit("layerchange", { layer: entry.layer, property: "info" });
      return;
    }
    // In another grid, the camera might not look at the volume.
    const { whole } = this.#camera;
    if (whole && !(before && isSameGrid(before, info))) this.#camera.set(whole);
    this.#viewer.emit("replaced", info);
  }
}

/** Whether the viewer reports an error by an event. */
function isReported(error: unknown): error is StreamError | RendererError {
  return error instanceof StreamError || error instanceof RendererError;
}
