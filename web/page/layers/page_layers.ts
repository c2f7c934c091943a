import type { Source } from "../../stream/source.ts";
import { layersTexts } from "../../texts/layers.ts";
import { messageOf, withoutOptions } from "../../texts/without_options.ts";
import type { Layer } from "../../viewer/layer.ts";
import type { Surface } from "../../viewer/types.ts";
import type { Viewer } from "../../viewer/viewer.ts";
import {
  contentOf,
  type LayerAddress,
  type LayerContent,
  type LayerPlace,
  type LayerState,
  type LayersView,
  layersOfAddress,
  plainLayer,
} from "../address/layer_address.ts";
import type { SurfaceSettings } from "../panel/surface_settings.ts";
import { inFreeColour, titleOfPlace, titleOfState } from "./layer_defaults.ts";
import type { Drop, LayerEntry } from "./layer_rows.ts";
import { Solo } from "./solo.ts";

/** The functions that the layers need from their page. */
export interface PageLayersHost {
  readonly viewer: Viewer;
  readonly surfaces: SurfaceSettings;
  /** The title of the page's volume. */
  title(): string;
  /** The view has changed. */
  changed(): void;
  /** Lays the page out after a change that does not affect the view. */
  render(): void;
  /** Another layer was chosen. */
  chosen(): void;
  note(text: string): void;
  /** Saves the present picture as a scene. */
  saveScene(): void;
  /** Adds volumes in files of this device; null while the code for them has not loaded. */
  takeFiles(): ((files: readonly File[]) => void) | null;
}

/** A layer that is being added. */
interface Pending {
  state: LayerState;
  /** Its index in the list. */
  at: number;
  /** The indices of the other layers, by their keys. Layers without an index come first. */
  indices: ReadonlyMap<number, number>;
  cancel: AbortController;
}

type Item = { key: number; layer: Layer } | { key: number; pending: Pending };

/**
 * The layers of a page. It knows the chosen layer and the origin of each layer, and applies the changes
 * that come from the list, from undo and from the address. The viewer holds the layers themselves. The
 * first one is the volume of the page.
 */
export class PageLayers {
  readonly #host: PageLayersHost;
  readonly #viewer: Viewer;
  #nextKey = 0;
  readonly #known = new WeakMap<Layer, { key: number; place: LayerPlace }>();
  /** The layers that the address opens without parameters, in their initial state. */
  #opened: LayersView["opened"] = [];
  #pending: readonly Pending[] = [];
  #chosen: Layer | null = null;
  /** The volume of the chosen layer when its values were last read. */
  #chosenContent: string | undefined;
  readonly #problems = new Map<number, string>();
  readonly #solo = new Solo();
  /** The layers while the page opens its volume again. */
  #reopening: LayersView | null = null;

  constructor(host: PageLayersHost) {
    this.#host = host;
    const { viewer } = host;
    this.#viewer = viewer;
    viewer.on("layeradd", (layer) => this.#added(layer));
    viewer.on("layerremove", (layer) => {
      if (layer === this.#chosen) this.#choose(null);
      this.#changed();
    });
    viewer.on("layermove", () => this.#changed());
    viewer.on("layerchange", ({ layer, property }) => {
      if (property === "visible" && layer.visible) this.#problems.delete(this.#keyOf(layer));
      if (layer === this.#chosen && property !== "name") this.#rereadChosen();
      this.#changed();
    });
    viewer.on("layererror", ({ layer, error }) => {
      this.#problems.set(this.#keyOf(layer), messageOf(error));
      host.changed();
    });
    // A layer that is shown for the first time has now been opened.
    viewer.on("progress", () => {
      const { info } = this.#chosen ?? {};
      if (info && info.contentId !== this.#chosenContent) this.#rereadChosen();
    });
  }

  #changed(): void {
    if (!this.#reopening) this.#host.changed();
  }

  /** The key of a layer of the viewer. */
  #keyOf(layer: Layer): number {
    const known = this.#known.get(layer);
    if (known) return known.key;
    const pending = this.#pending.find(({ state }) => state.source === layer.sources);
    const key = pending?.state.key ?? this.#nextKey++;
    this.#known.set(layer, { key, place: pending?.state.place ?? {} });
    return key;
  }

  #stateOf(layer: Layer): LayerState {
    const key = this.#keyOf(layer);
    const { place = {} } = this.#known.get(layer) ?? {};
    const { sources: source, name, group, visible, surfaces, transform, label } = layer;
    return { key, source, place, name, group, visible, surfaces, transform, label };
  }

  /** The layers as they are listed, with those that are being added. */
  get #items(): Item[] {
    const items: Item[] = this.#viewer.layers.map((layer) => ({ key: this.#keyOf(layer), layer }));
    for (const pending of [...this.#pending].sort((a, b) => a.at - b.at)) {
      items.splice(pending.at, 0, { key: pending.state.key, pending });
    }
    return items;
  }

  #layerOf(key: number): Layer | undefined {
    return this.#viewer.layers.find((layer) => this.#keyOf(layer) === key);
  }

  get #firstKey(): number {
    return this.#opened.find((layer) => layer !== undefined)?.key ?? 0;
  }

  /** The layers for the address and for undo. */
  get view(): LayersView {
    if (this.#reopening) return this.#reopening;
    const present = this.#items.map((item) =>
      "layer" in item ? this.#stateOf(item.layer) : item.pending.state,
    );
    return { opened: this.#opened, present };
  }

  /** The layers for the list. */
  get entries(): LayerEntry[] {
    const { chosen } = this;
    const others = this.#items.filter(
      (item) => !("layer" in item) || !this.isFurtherPart(item.layer),
    );
    return others.map((item): LayerEntry => {
      const isOpening = !("layer" in item);
      const { key } = item;
      const state = isOpening ? item.pending.state : item.layer;
      const [surface] = state.surfaces;
      const { fault } = (!isOpening && item.layer.progress) || {};
      return {
        key,
        title: isOpening ? titleOfState(item.pending.state) : this.titleOf(item.layer),
        group: state.group,
        visible: state.visible,
        colour: surface?.colour,
        opacity: surface?.opacity,
        isChosen: !isOpening && item.layer === chosen,
        isFirst: key === this.#firstKey,
        isOpening,
        problem: (fault && withoutOptions(fault.message)) ?? this.#problems.get(key),
      };
    });
  }

  /** Whether an earlier layer stands for this one in the list: both are parts of one volume. */
  isFurtherPart(layer: Layer): boolean {
    const first = this.#viewer.layers.find((each) => each.sharesVolumeWith(layer));
    return first !== undefined && first !== layer;
  }

  titleOf(layer: Layer): string {
    if (layer.partOf) return layer.partOf;
    const { title, name } = layer.info?.metadata ?? {};
    const own = layer.name || title || name || titleOfState(this.#stateOf(layer));
    return own || this.#host.title();
  }

  /** The title of a layer that was hit; undefined if there is no other. */
  titleOfHit(id: number): string | undefined {
    const { layers } = this.#viewer;
    const layer = layers.length > 1 ? layers.find((each) => each.id === id) : undefined;
    return layer && this.titleOf(layer);
  }

  /** The volume of the page. */
  get first(): Layer | undefined {
    return this.#layerOf(this.#firstKey);
  }

  /** The layer on which isovalue and surfaces act. */
  get chosen(): Layer | undefined {
    return this.#chosen ?? this.first;
  }

  #choose(layer: Layer | null): void {
    this.#chosen = layer;
    this.#chosenContent = layer?.info?.contentId;
    this.#host.surfaces.choose(layer);
    this.#host.chosen();
  }

  #rereadChosen(): void {
    const content = this.#chosen?.info?.contentId;
    const isSame = content === this.#chosenContent;
    this.#chosenContent = content;
    const { surfaces } = this.#host;
    if (!isSame || this.#chosen?.surfaces !== surfaces.surfaces) surfaces.reread();
  }

  // ---- Actions of the list ----

  choose(key: number): void {
    const layer = this.#layerOf(key);
    if (layer && layer !== this.chosen) this.#choose(key === this.#firstKey ? null : layer);
  }

  show(keys: readonly number[], isVisible: boolean): void {
    this.#solo.forget();
    const wanted = new Set(keys);
    for (const layer of this.#viewer.layers) {
      if (wanted.has(this.#keyOf(layer))) layer.visible = isVisible;
    }
  }

  /** Whether the chosen layer is shown alone by `solo`. */
  get isChosenSolo(): boolean {
    const { chosen } = this;
    return chosen !== undefined && this.#solo.isAlone(chosen, this.#viewer.layers);
  }

  /** Hides all other layers, or shows the layers that were visible before. */
  solo(key: number): void {
    const layer = this.#layerOf(key);
    if (layer) this.#solo.toggle(layer, this.#viewer.layers);
  }

  /** Changes the first surface of a layer. */
  changeSurface(key: number, change: Partial<Surface>): void {
    const layer = this.#layerOf(key);
    if (!layer) return;
    if (layer === this.chosen) this.#host.surfaces.actions.changeSurface(0, change);
    else
      layer.surfaces = layer.surfaces.map((each, i) => (i === 0 ? { ...each, ...change } : each));
  }

  change(key: number, change: Partial<Pick<LayerContent, "name" | "group">>): void {
    const layer = this.#layerOf(key);
    if (layer) Object.assign(layer, change);
  }

  drop(key: number, { group, before, after }: Drop): void {
    const layer = this.#layerOf(key);
    if (!layer) return;
    const others = this.#viewer.layers.map((each) => this.#keyOf(each)).filter((k) => k !== key);
    const next = after !== undefined ? others.indexOf(after) + 1 : others.indexOf(before ?? -1);
    this.#viewer.moveLayer(layer, next < 0 ? others.length : next);
    if (layer.group !== group) layer.group = group;
  }

  remove(key: number): void {
    if (key === this.#firstKey) return;
    for (const { state, cancel } of this.#pending) if (state.key === key) cancel.abort();
    const layer = this.#layerOf(key);
    for (const part of [...this.#viewer.layers]) {
      if (part === layer || (layer && part.sharesVolumeWith(layer))) part.remove();
    }
  }

  // ---- Adding ----

  /** Adds stores to the picture, and chooses the first. Resolves to whether one could be opened. */
  async addAll(
    layers: readonly { source: Source; place: LayerPlace; content: Partial<LayerState> }[],
  ): Promise<boolean> {
    const states = layers.map(({ content, ...of }) => {
      return { ...plainLayer, ...content, key: this.#nextKey++, ...of };
    });
    const indices = new Map(states.map(({ key }, i) => [key, this.#items.length + i]));
    const added = await Promise.all(states.map((state) => this.#addState(state, indices)));
    const first = states.find((_, i) => added[i]);
    if (first) this.choose(first.key);
    return first !== undefined;
  }

  async #addState(state: LayerState, indices: ReadonlyMap<number, number>): Promise<boolean> {
    const cancel = new AbortController();
    const at = indices.get(state.key) ?? this.#items.length;
    const pending = { state, at, indices, cancel };
    this.#pending = [...this.#pending, pending];
    this.#host.changed();
    const { source, name, group, visible, surfaces, transform, label = null } = state;
    try {
      await this.#viewer.addLayer(source, {
        ...{ name, group, visible, transform, label, signal: cancel.signal },
        ...(surfaces.length > 0 && { surfaces }),
      });
      return true;
    } catch (error) {
      const reason = messageOf(error);
      const text = layersTexts.notOpened(titleOfState(state), reason);
      if (!cancel.signal.aborted) this.#host.note(text);
      return false;
    } finally {
      this.#pending = this.#pending.filter((each) => each !== pending);
      this.#host.changed();
    }
  }

  #added(layer: Layer): void {
    if (this.#reopening) return;
    const pending = this.#pending.find(({ state }) => state.source === layer.sources);
    this.#keyOf(layer);
    if (pending) {
      this.#pending = this.#pending.filter((each) => each !== pending);
      const { at, indices } = pending;
      const isBefore = (each: Layer) =>
        each !== layer && (indices.get(this.#keyOf(each)) ?? -1) < at;
      this.#viewer.moveLayer(layer, this.#viewer.layers.filter(isBefore).length);
      if (pending.state.surfaces.length === 0) {
        layer.surfaces = inFreeColour(layer, this.#viewer.layers);
      }
    }
    this.#host.changed();
  }

  // ---- Undo, the address, and opening again ----

  /** Shows the layers of an earlier view; null: as the address itself opened them. */
  restore(view: LayersView | null): void {
    const states = view?.present ?? this.#opened.filter((layer) => layer !== undefined);
    const wanted = new Map(states.map(({ key }, at) => [key, at]));
    for (const { state, cancel } of this.#pending) if (!wanted.has(state.key)) cancel.abort();
    for (const layer of [...this.#viewer.layers]) {
      const key = this.#keyOf(layer);
      if (!wanted.has(key) && key !== this.#firstKey) layer.remove();
    }
    const present = new Map(this.#items.map((item) => [item.key, item]));
    for (const state of states) {
      const item = present.get(state.key);
      if (!item) void this.#addState(state, wanted);
      else if ("layer" in item) this.#apply(item.layer, state);
    }
    const order = states.flatMap(({ key }) => this.#layerOf(key) ?? []);
    order.forEach((layer, i) => {
      this.#viewer.moveLayer(layer, i);
    });
    if (this.#chosen) this.#rereadChosen();
    this.#host.changed();
  }

  /** The surfaces of the page's volume are restored by SurfaceSettings. */
  #apply(layer: Layer, content: LayerContent): void {
    if (layer.name !== content.name) layer.name = content.name;
    if (layer.group !== content.group) layer.group = content.group;
    layer.visible = content.visible;
    if (layer.transform.join() !== content.transform.join()) layer.transform = content.transform;
    const isFirst = this.#keyOf(layer) === this.#firstKey;
    const hasOther = JSON.stringify(layer.surfaces) !== JSON.stringify(content.surfaces);
    if (!isFirst && hasOther && content.surfaces.length > 0) layer.surfaces = content.surfaces;
  }

  /** Adds and changes layers as the address states. `sourceOf`: opens a place, or returns the reason why it cannot. */
  async openAddress(
    layers: readonly LayerAddress[],
    order: readonly number[] | undefined,
    sourceOf: (place: LayerPlace) => Promise<Source | string>,
  ): Promise<void> {
    const make = async (layer: LayerAddress): Promise<LayerState | undefined> => {
      const place = layer.volume ? { volume: layer.volume } : { src: layer.src ?? "" };
      const content = contentOf(plainLayer, layer);
      const source = await sourceOf(place);
      const { label = null } = layer;
      const key = this.#nextKey++;
      if (typeof source !== "string") return { ...content, key, source, place, label };
      this.#host.note(layersTexts.notOpened(content.name || titleOfPlace(place), source));
      return undefined;
    };
    const opened = this.#opened;
    const { present, unknown } = await layersOfAddress(opened, layers, order, make);
    if (unknown > 0) this.#host.note(layersTexts.unknownLayers(unknown));
    this.restore({ opened, present });
  }

  /** Called before the page opens its volume again, which closes all layers. */
  closing(): void {
    this.#reopening = this.view;
    this.#choose(null);
    for (const { cancel } of this.#pending) cancel.abort();
  }

  /**
   * The page has opened its volume, or the layers of its scene, of which missing ones are null. If it has opened them
   * again, the other layers are now added again.
   */
  opened(layers: readonly (Layer | null)[]): void {
    const view = this.#reopening;
    this.#opened = layers.map((layer, i) => {
      const before = this.#opened[i];
      if (!layer) return before;
      this.#known.set(layer, { key: before?.key ?? this.#nextKey++, place: {} });
      return before ?? this.#stateOf(layer);
    });
    this.#reopening = null;
    if (view) this.restore(view);
  }
}
