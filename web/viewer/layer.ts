import type { StoreInfo } from "../core/types.ts";
import type { StreamSession } from "../stream/session.ts";
import type { StoreAccess } from "../stream/session_parts.ts";
import type { Source } from "../stream/source.ts";
import type { Progress } from "../stream/types.ts";
import type { StepSources } from "./layer_steps.ts";
import { checkedTransform, identity, type Transform, volumeScaleOf } from "./transform.ts";
import type { Label, Surface } from "./types.ts";

/** The properties of a layer that can change. `info` changes if the source's store was replaced. */
export type LayerProperty = "name" | "group" | "surfaces" | "visible" | "transform" | "info";

export interface LayerOptions {
  /** A name for users. Default: empty. */
  name?: string;
  /** The name of its group, for users: layers of a group are listed together. Default: empty, in none. */
  group?: string;
  /**
   * The name of a volume of which the layer shows a part, such as a refinement level of an adaptive grid. Layers with
   * the same name have the same surfaces, visibility and transform: a change of one changes all. Default: empty, none.
   */
  partOf?: string;
  /** Default: one surface at the volume's first suggested isovalue. */
  surfaces?: readonly Surface[];
  /** Default: true. The store of a hidden layer is not opened. */
  visible?: boolean;
  /** Default: the identity. */
  transform?: Transform;
  /** The label that the layer shows, with the volume in the world of its store. Default: none. */
  label?: Label | null;
}

/** The functions that a layer needs from its list. */
export interface LayerOwner {
  source(): Source;
  sources(): Source | StepSources;
  hasSteps(): boolean;
  info(): StoreInfo | null;
  progress(): Progress | null;
  /** Null while the layer is hidden or being opened. */
  session(): StreamSession | null;
  changed(property: LayerProperty): void;
  remove(): void;
}

/**
 * One volume of a viewer: a store with its surfaces, its visibility and its transform. Viewer.open and
 * Viewer.addLayer create layers. After `remove`, changes have no effect.
 */
export class Layer {
  /** Identifies the layer within its viewer. Later layers have larger numbers. */
  readonly id: number;
  /** The argument of `Viewer.addLayer`. */
  readonly label: Label | null;
  /** The argument of `Viewer.addLayer`; empty: none. */
  readonly partOf: string;
  readonly #owner: LayerOwner;
  #name: string;
  #group: string;
  #surfaces: readonly Surface[];
  #visible: boolean;
  #transform: Transform;

  /** Throws a RangeError: see `transform`. */
  constructor(id: number, options: LayerOptions, owner: LayerOwner) {
    this.id = id;
    this.label = options.label ?? null;
    this.partOf = options.partOf ?? "";
    this.#owner = owner;
    this.#name = options.name ?? "";
    this.#group = options.group ?? "";
    this.#surfaces = [...(options.surfaces ?? [])];
    this.#visible = options.visible ?? true;
    this.#transform = checkedTransform(options.transform ?? identity);
  }

  /** The source of its store. If the layer has a store for each step, the source of the step that is shown. */
  get source(): Source {
    return this.#owner.source();
  }

  /** The argument of `Viewer.addLayer`, with which the same layer can be added again. */
  get sources(): Source | StepSources {
    return this.#owner.sources();
  }

  /** Whether the layer has a store for each step of `Viewer.time`. */
  get hasSteps(): boolean {
    return this.#owner.hasSteps();
  }

  /** The description of the store, with its grid before `transform`. Null until it has been read. */
  get info(): StoreInfo | null {
    return this.#owner.info();
  }

  /** The data still missing for the present view; null while the layer is hidden or being opened. */
  get progress(): Progress | null {
    return this.#owner.progress();
  }

  /** StreamSession.bytesOf; undefined while the layer is hidden or being opened. */
  bytesOf(isovalue: number): number | undefined {
    return this.#owner.session()?.bytesOf(isovalue);
  }

  /** StreamSession.access; undefined while the layer is hidden or being opened. */
  get storeAccess(): StoreAccess | undefined {
    return this.#owner.session()?.access;
  }

  /** StreamSession.quantizedIsovalue; undefined while the layer is hidden or being opened. */
  quantizedIsovalue(isovalue: number): number | undefined {
    return this.#owner.session()?.quantizedIsovalue(isovalue);
  }

  get name(): string {
    return this.#name;
  }

  set name(name: string) {
    this.#name = name;
    this.#owner.changed("name");
  }

  get group(): string {
    return this.#group;
  }

  set group(group: string) {
    this.#group = group;
    this.#owner.changed("group");
  }

  get surfaces(): readonly Surface[] {
    return this.#surfaces;
  }

  /** At most `maxSurfaces`. The next frame draws their resident samples. */
  set surfaces(surfaces: readonly Surface[]) {
    this.#surfaces = [...surfaces];
    this.#owner.changed("surfaces");
  }

  get visible(): boolean {
    return this.#visible;
  }

  /** A hidden layer holds no samples and fetches nothing. One that is shown again is opened again. */
  set visible(visible: boolean) {
    if (visible === this.#visible) return;
    this.#visible = visible;
    this.#owner.changed("visible");
  }

  get transform(): Transform {
    return this.#transform;
  }

  /** Throws a RangeError if it is not affine, or makes volumes flat. Fetches nothing by itself. */
  set transform(transform: Transform) {
    this.#transform = checkedTransform(transform);
    this.#owner.changed("transform");
  }

  /** Whether both are parts of one volume. */
  sharesVolumeWith(other: Layer): boolean {
    return this.partOf !== "" && this.partOf === other.partOf;
  }

  /** The label with its volume in the world of the picture. Null: the layer shows no label. */
  get placedLabel(): Label | null {
    const { label } = this;
    return label && { ...label, volume: label.volume * volumeScaleOf(this.#transform) };
  }

  /** Takes the layer out of the viewer: ends its requests, and frees its memory. */
  remove(): void {
    this.#owner.remove();
  }
}
