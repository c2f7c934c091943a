import { keptBlob } from "../../device/kept_stores.ts";
import { isForbiddenAddress } from "../../device/no_upload.ts";
import { BlobSource } from "../../stream/blob_source.ts";
import type { Source } from "../../stream/source.ts";
import { layersTexts } from "../../texts/layers.ts";
import type { Layer } from "../../viewer/layer.ts";
import { isIdentity } from "../../viewer/transform.ts";
import type { LayerAddress, LayerPlace } from "../address/layer_address.ts";
import { addressIn, openTarget } from "../address/open_target.ts";
import { deviceAddress } from "../address/target.ts";
import { frameNotes, type PlacedLayer } from "./frames_of_reference.ts";
import { LayersSection } from "./layers_section.ts";
import { PageLayers, type PageLayersHost } from "./page_layers.ts";

/** The layers of a page with their section in the panel. */
export class LayersList {
  readonly layers: PageLayers;
  readonly section: LayersSection;
  readonly #host: PageLayersHost;

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

  /** What the visitor should know of the places of the layers. */
  #notes(): string[] {
    const { first } = this.layers;
    const others = this.#host.viewer.layers.filter((layer) => layer !== first);
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
      takeFiles: this.#host.takeFiles(),
    });
  }

  /** Adds a store to the picture. Resolves to whether it could be opened. */
  async add(place: LayerPlace): Promise<boolean> {
    const source = await sourceOf(place);
    if (typeof source !== "string") return this.layers.add(source, place);
    this.#host.note(source);
    return false;
  }

  /** The layers of the page's address. */
  openAddress(
    layers: readonly LayerAddress[],
    order: readonly number[] | undefined,
  ): Promise<void> {
    return this.layers.openAddress(layers, order, sourceOf);
  }
}

/** The source of a place, or why it cannot be opened. */
async function sourceOf(place: LayerPlace): Promise<Source | string> {
  const { src } = place;
  if (src?.startsWith(deviceAddress)) {
    const kept = await keptBlob(src.slice(deviceAddress.length));
    return kept ? new BlobSource(kept.blob, kept.store.name) : layersTexts.notHere;
  }
  const address = src === undefined ? undefined : addressIn(src);
  if (address && isForbiddenAddress(address)) return layersTexts.cutOff(address.host);
  const target = openTarget(place);
  return target && "source" in target ? target.source() : layersTexts.notAStore;
}
