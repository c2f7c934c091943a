import { keptBlob } from "../../device/kept_stores.ts";
import { isForbiddenAddress } from "../../device/no_upload.ts";
import type { AddressedStores } from "../../scene/addressed_stores.ts";
import type { SceneSource } from "../../scene/scene_source.ts";
import { BlobSource } from "../../stream/blob_source.ts";
import type { Source } from "../../stream/source.ts";
import { layersTexts } from "../../texts/layers.ts";
import { messageOf } from "../../texts/without_options.ts";
import type { Layer } from "../../viewer/layer.ts";
import { isIdentity } from "../../viewer/transform.ts";
import type { LayerAddress, LayerPlace } from "../address/layer_address.ts";
import { addressIn, openTarget } from "../address/open_target.ts";
import { deviceAddress } from "../address/target.ts";
import { sceneSource } from "../shell/site.ts";
import { frameNotes, type PlacedLayer } from "./frames_of_reference.ts";
import { LayersSection } from "./layers_section.ts";
import { PageLayers, type PageLayersHost } from "./page_layers.ts";

/** The layers of a page with their section in the panel. */
export class LayersList {
  readonly layers: PageLayers;
  readonly section: LayersSection;
  readonly #host: PageLayersHost;
  /** The stores in bundles, for layers of scenes that were added. */
  #stores: AddressedStores | null = null;

  constructor(host: PageLayersHost) {
    this.#host = host;
    const layers = new PageLayers(host);
    this.layers = layers;
    this.section = new LayersSection(
      () => {
        const { entries } = layers;
        return { entries, isSolo: layers.isChosenSolo, notes: this.#notes() };
      },
      {
        choose: (key) => layers.choose(key),
        show: (keys, isVisible) => layers.show(keys, isVisible),
        solo: (key) => layers.solo(key),
        changeSurface: (key, change) => layers.changeSurface(key, change),
        change: (key, change) => layers.change(key, change),
        drop: (key, drop) => layers.drop(key, drop),
        remove: (key) => layers.remove(key),
        add: () => void this.#openDialog(),
        save: () => host.saveScene(),
      },
    );
  }

  /** Notes on the positions of the layers in the world. */
  #notes(): string[] {
    const { first } = this.layers;
    const others = this.#host.viewer.layers.filter(
      (layer) => layer !== first && !this.layers.isFurtherPart(layer),
    );
    const placed = others.flatMap((layer) => this.#placed(layer) ?? []);
    const firstPlaced = first && this.#placed(first);
    return firstPlaced ? frameNotes(firstPlaced, placed) : [];
  }

  #placed(layer: Layer): PlacedLayer | undefined {
    const { info, transform } = layer;
    return info && isIdentity(transform) ? { title: this.layers.titleOf(layer), info } : undefined;
  }

  async #openDialog(): Promise<void> {
    const { openAddDialog } = await import("./add_dialog.ts");
    await openAddDialog({
      add: (place) => void this.add(place),
      addScene: (name) => void this.#addScene(name, () => sceneSource(name)),
      takeFiles: this.#host.takeFiles(),
    });
  }

  /** Adds a store to the picture. Resolves to whether it could be opened. */
  async add(place: LayerPlace): Promise<boolean> {
    const target = place.src === undefined ? undefined : openTarget(place);
    if (target && "scene" in target && !addressIn(place.src ?? "")?.hash) {
      return this.#addScene(target.name, target.scene);
    }
    const source = await this.#sourceOf(place);
    if (typeof source !== "string") return this.layers.addAll([{ source, place, content: {} }]);
    this.#host.note(source);
    return false;
  }

  /** The layers of the page's address. */
  openAddress(
    layers: readonly LayerAddress[],
    order: readonly number[] | undefined,
  ): Promise<void> {
    return this.layers.openAddress(layers, order, (place) => this.#sourceOf(place));
  }

  /** Adds all layers of a scene. Resolves to whether one could be opened. */
  async #addScene(name: string, load: () => Promise<SceneSource>): Promise<boolean> {
    try {
      const [scene, { layersOfScene }] = await Promise.all([load(), import("./scene_layers.ts")]);
      const layers = await layersOfScene(this.#host.viewer, scene);
      if (typeof layers !== "string") return await this.layers.addAll(layers);
      this.#host.note(layers);
    } catch (error) {
      const reason = messageOf(error);
      this.#host.note(layersTexts.notOpened(name, reason));
    }
    return false;
  }

  /** The source of a place, or a message that states why it cannot be opened. */
  async #sourceOf(place: LayerPlace): Promise<Source | string> {
    const { src } = place;
    if (src?.startsWith(deviceAddress)) {
      const kept = await keptBlob(src.slice(deviceAddress.length));
      return kept ? new BlobSource(kept.blob, kept.store.name) : layersTexts.notHere;
    }
    const address = src === undefined ? undefined : addressIn(src);
    if (address && isForbiddenAddress(address)) return layersTexts.cutOff(address.host);
    const target = openTarget(place);
    if (target && "source" in target) return target.source();
    if (!target || !address?.hash) return layersTexts.notAStore;
    const { AddressedStores } = await import("../../scene/addressed_stores.ts");
    this.#stores ??= new AddressedStores(await this.#host.viewer.core(), location.href);
    return this.#stores.source(address.href);
  }
}
