import { categoriesOf, merged } from "../core/categories.ts";
import type { Category, FieldInfo, StoreInfo } from "../core/types.ts";
import type { StreamSession } from "../stream/session.ts";
import { fieldOf } from "./field_of.ts";
import type { Layer } from "./layer.ts";
import type { LayerSteps } from "./layer_steps.ts";
import type { OpenVolume } from "./open_volume.ts";
import { isStreaming, type SceneLayer } from "./scene.ts";
import { placed } from "./transform.ts";
import type { Camera } from "./types.ts";
import type { OpenOptions } from "./viewer_events.ts";

/**
 * With more layers than this, some work for each layer would take too long: occlusion queries, and fetching
 * coarse levels for other isovalues in advance. It is left out.
 */
export const manyLayers = 16;

/** A layer with its volume, and the viewer's state for it. */
export interface LayerEntry {
  readonly layer: Layer;
  /** The volume that is shown: that of the present step, if the layer has steps. */
  volume: OpenVolume;
  /** The volumes of its steps; null if the layer is the same at every step. */
  readonly steps: LayerSteps | null;
  /** Whether it is among `LayerList.listed`. */
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

/** The store of a layer, with its grid after the layer's transform. Null until it is open. */
export function placedOf(
  { layer, volume }: Pick<LayerEntry, "layer" | "volume">,
  { info } = volume,
): StoreInfo | null {
  return info && placed(info, layer.transform);
}

/** The volumes of a layer that are open, being opened, or shown. */
export function volumesOf({ volume, steps }: LayerEntry): OpenVolume[] {
  return steps ? [...new Set([volume, ...steps.volumes])] : [volume];
}

/**
 * The layers of a viewer, including those that are being opened. They are in the order in which they were added,
 * unless they were moved.
 */
export class LayerList {
  #entries: readonly LayerEntry[] = [];
  #first: LayerEntry | undefined;

  get entries(): readonly LayerEntry[] {
    return this.#entries;
  }

  add(entry: LayerEntry): void {
    this.#entries = [...this.#entries, entry];
    this.#first ??= entry;
  }

  has(entry: LayerEntry): boolean {
    return this.#entries.includes(entry);
  }

  remove(entry: LayerEntry): void {
    this.#entries = this.#entries.filter((each) => each !== entry);
    if (entry !== this.#first) return;
    const [first, ...others] = this.#entries;
    this.#first = others.reduce((a, b) => (a && b.layer.id < a.layer.id ? b : a), first);
  }

  /**
   * Puts a layer at this index of `listed`. Throws a RangeError if the layer or the index does not exist.
   * Returns whether this changes the order.
   */
  move(layer: Layer, index: number): boolean {
    const entry = this.#entries.find((each) => each.layer === layer && each.isListed);
    if (!entry) throw new RangeError("the layer is not one of this viewer: see Viewer.layers");
    const others = this.#entries.filter((each) => each !== entry);
    const listed = others.filter(({ isListed }) => isListed);
    if (!(Number.isInteger(index) && index >= 0 && index <= listed.length)) {
      throw new RangeError(`a layer has an index from 0 to ${listed.length}, found ${index}`);
    }
    const isOther = this.listed[index] !== layer;
    const next = listed[index];
    const at = next ? others.indexOf(next) : others.length;
    if (isOther) this.#entries = [...others.slice(0, at), entry, ...others.slice(at)];
    return isOther;
  }

  clear(): void {
    this.#entries = [];
    this.#first = undefined;
  }

  /** Viewer.layers. */
  get listed(): Layer[] {
    return this.#entries.filter(({ isListed }) => isListed).map(({ layer }) => layer);
  }

  /** The layer that was added first, even if it was moved. It is also the renderer's first volume. */
  get first(): LayerEntry | undefined {
    return this.#first;
  }

  /** The number of the first layer in the renderer. */
  get firstNumber(): number {
    return this.first?.volume.number ?? 0;
  }

  /** The `Layer.id` of the layer to which a volume of the renderer belongs. Its steps have consecutive numbers. */
  idOf(volume: number): number {
    const ids = this.#entries.map(({ layer }) => layer.id).filter((id) => id <= volume);
    return Math.max(...ids);
  }

  /** The store of the first layer. Null until it is open. */
  get firstInfo(): StoreInfo | null {
    return this.first?.volume.info ?? null;
  }

  /** The same, with its grid after the layer's transform. */
  get firstPlaced(): StoreInfo | null {
    const { first } = this;
    return (first && placedOf(first)) ?? null;
  }

  /** Null until the first layer is open, and while it is hidden. */
  get firstSession(): StreamSession | null {
    return this.first?.volume.session ?? null;
  }

  /** That of the first open layer that shows a field; null if none does. */
  get fieldSession(): StreamSession | null {
    return this.sessions.find(({ shownField }) => shownField !== null) ?? null;
  }

  /** The categories of the fields that layers show, by value; empty if their values are no labels. */
  get categories(): Category[] {
    const shown = this.sessions.flatMap(({ shownField }) => shownField ?? []);
    return merged(shown.map(({ metadata }) => categoriesOf(metadata)));
  }

  /** The labels of these around the surfaces that are drawn. */
  get labels(): ReadonlySet<number> {
    return new Set(this.sessions.flatMap(({ fieldLabels }) => [...fieldLabels]));
  }

  /** The field of the first open layer that has one with this name. */
  fieldNamed(name: string | null): FieldInfo | null {
    if (name === null) return null;
    const [found] = this.sessions.flatMap(({ info }) => fieldOf(info, name) ?? []);
    return found ?? null;
  }

  get sessions(): StreamSession[] {
    return this.#entries.flatMap(({ volume }) => volume.session ?? []);
  }

  /** Whether a layer is being opened, or is open. */
  get hasAny(): boolean {
    return this.#entries.some(({ layer, volume }) => layer.visible || volume.info !== null);
  }

  /** Whether a visible layer is being opened, or its session has not reported yet what it fetches. */
  get isWaiting(): boolean {
    return this.#entries.some(
      ({ layer, volume }) => layer.visible && !volume.progress && volume.error === null,
    );
  }

  /** The number of visible layers whose first surface is still to arrive, or to be shown. */
  get missing(): number {
    return this.#entries.filter(
      ({ layer, volume }) =>
        layer.visible && volume.error === null && !volume.session?.showsFirstSurface,
    ).length;
  }

  /** Whether a picture can be drawn: a volume is open, or hidden. */
  get isOpen(): boolean {
    return this.#entries.some(({ layer, volume }) => volume.session || !layer.visible);
  }

  /** The layers that are drawn. stepCellPixels: of those that have steps. */
  shown(stepCellPixels: number | undefined): SceneLayer[] {
    return this.#entries.flatMap(({ layer, volume, steps }) => {
      const { session, progress } = volume;
      if (!session) return [];
      const isovalues = layer.surfaces.map((surface) => surface.isovalue);
      const { transform } = layer;
      const { number } = volume;
      const isDone = progress !== null && !isStreaming(progress);
      const cells = steps && stepCellPixels !== undefined ? { stepCellPixels } : {};
      return [{ number, session, isovalues, transform, isDone, ...cells }];
    });
  }
}
