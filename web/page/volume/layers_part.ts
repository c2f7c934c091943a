import type { ShownScene } from "../../scene/open_scene.ts";
import { pageTexts } from "../../texts/page.ts";
import type { Layer } from "../../viewer/layer.ts";
import type { Viewer } from "../../viewer/viewer.ts";
import type { LayerPlace, LayersView } from "../address/layer_address.ts";
import { keptLayers, type UrlState } from "../address/url_state.ts";
import type { LayersList } from "../layers/layers_list.ts";
import type { PageLayersHost } from "../layers/page_layers.ts";

/**
 * The list of layers of a volume page. Its code is loaded at its first use, or when there is more than one layer.
 * Before that, the page has no list.
 */
export class LayersPart {
  readonly #viewer: Viewer;
  readonly #url: UrlState;
  readonly #search: string;
  readonly #host: PageLayersHost;
  #list: LayersList | null = null;
  #wasOfSeveral = false;
  /** The layers that the address has opened; null while it opens them. */
  #opened: readonly (Layer | null)[] | null = null;
  #isAddressRead = false;
  #loading: Promise<LayersList | null> | null = null;

  /** Adds volumes in files of this device to the picture; null until the code for them has loaded. */
  takeFiles: ((files: readonly File[]) => void) | null = null;

  /** The scene that the page has opened. Null if it has opened a single store. */
  scene: ShownScene | null = null;

  constructor(host: Omit<PageLayersHost, "takeFiles">, url: UrlState, search: string) {
    this.#viewer = host.viewer;
    this.#url = url;
    this.#search = search;
    this.#host = { ...host, takeFiles: () => this.takeFiles };
    host.viewer.on("layeradd", () => {
      if (this.#opened && this.#isOfSeveral) void this.load();
    });
  }

  get #isOfSeveral(): boolean {
    return this.#viewer.layers.length > 1;
  }

  /**
   * Whether the list is shown automatically, because there are several layers, or have been before.
   */
  get isOpen(): boolean {
    this.#wasOfSeveral ||= this.#isOfSeveral;
    return this.#wasOfSeveral;
  }

  /** The section of the panel; null until it has loaded. */
  get element(): HTMLElement | null {
    return this.#list?.section.element ?? null;
  }

  /** The layer to which isovalue and surfaces apply. Undefined if there is only one. */
  get chosen(): Layer | undefined {
    return this.#isOfSeveral ? this.#list?.layers.chosen : undefined;
  }

  titleOf(layer: Layer): string {
    return this.#list?.layers.titleOf(layer) ?? layer.name;
  }

  /** The title of the layer of a pick; undefined if there is only one. */
  titleOfHit(id: number): string | undefined {
    return this.#list?.layers.titleOfHit(id);
  }

  /** The layers for the address and for undo. Null until the code has loaded. */
  get view(): LayersView | null {
    return this.#list?.layers.view ?? null;
  }

  /** Shows the chosen layer, which is hidden. */
  showChosen(): void {
    const { chosen } = this;
    if (chosen) chosen.visible = true;
  }

  restore(view: LayersView | null): void {
    this.#list?.layers.restore(view);
  }

  refresh(): void {
    this.#list?.section.refresh();
  }

  /** Call it when the page opens its volume or its scene, which closes all layers. */
  closing(): void {
    this.#opened = null;
    this.#list?.layers.closing();
  }

  /**
   * Called when the volume or the scene of the page is open. The first call also opens the layers of the address.
   */
  async opened(scene: ShownScene | null): Promise<void> {
    this.scene = scene;
    const layers = scene?.layers ?? this.#viewer.layers;
    this.#opened = layers;
    this.#list?.layers.opened(layers);
    if (this.#isOfSeveral) void this.load();
    if (this.#isAddressRead) return;
    this.#isAddressRead = true;
    const isInAddress = this.#url.layers ?? this.#url.layerOrder;
    const { layers: added, layerOrder } = isInAddress ? this.#url : keptLayers(this.#search);
    if (!added && !layerOrder) return;
    const list = await this.load();
    if (list) await list.openAddress(added ?? [], layerOrder);
  }

  /** Adds a store to the picture. Resolves to whether it could be opened. */
  async add(place: LayerPlace): Promise<boolean> {
    return (await this.load())?.add(place) ?? false;
  }

  /** Resolves to null if the code could not be loaded. */
  load(): Promise<LayersList | null> {
    this.#loading ??= import("../layers/layers_list.ts").then(
      ({ LayersList }) => {
        this.#list = new LayersList(this.#host);
        if (this.#opened) this.#list.layers.opened(this.#opened);
        this.#host.render();
        return this.#list;
      },
      () => {
        this.#loading = null;
        this.#host.note(pageTexts.noSection);
        return null;
      },
    );
    return this.#loading;
  }
}
