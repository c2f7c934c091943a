import type { StoreInfo } from "../core/types.ts";
import { faults, slowWait } from "../stream/faults.ts";
import type { Source } from "../stream/source.ts";
import { StreamError } from "../stream/types.ts";
import type { Layer, LayerProperty } from "../viewer/layer.ts";
import { RendererError } from "../viewer/renderer_error.ts";
import { sameValue } from "../viewer/same_value.ts";
import { firstSurface } from "../viewer/surfaces.ts";
import { checkedTransform, identity, type Transform } from "../viewer/transform.ts";
import type { Surface } from "../viewer/types.ts";
import type { Viewer } from "../viewer/viewer.ts";
import { isovaluesOf, surfacesOf, transformOf } from "./element_attributes.ts";

/** The functions that a layer needs from the element that shows it. */
export interface LayerPartHost {
  /** Called when the layer was added to the viewer. */
  added(): void;
  fault(error: StreamError | RendererError): void;
  /** The number of the colour of the layer's first surface. It is used if the element states no colours. */
  colourNumber(): number;
  /** Called when the layer has got, or no longer has, something to show. */
  wake(): void;
}

/**
 * The settings and the layer of an `<isosplat-layer>`. The settings are kept while there is no viewer. While there
 * is one, the layer is added to it, opened again after faults, and synchronized with the element.
 */
export class LayerPart {
  readonly #element: HTMLElement;
  #host: LayerPartHost | null = null;
  #viewer: Viewer | null = null;
  #source: Source | null = null;
  #layer: Layer | null = null;
  #info: StoreInfo | null = null;
  #opening: AbortController | null = null;
  #timer: ReturnType<typeof setTimeout> | undefined;
  #failures = 0;
  #fault: Error | null = null;
  /** The surfaces set by a program or taken from the layer. Null: the attributes, or else the store, determine them. */
  #surfaces: readonly Surface[] | null = null;
  /** The transform set by a program. Null: the attribute determines it. */
  #transform: Transform | null = null;
  #colourNumber = 0;

  constructor(element: HTMLElement) {
    this.#element = element;
  }

  get source(): Source | null {
    return this.#source;
  }

  setSource(source: Source | null): void {
    this.#source = source;
    this.#info = null;
    this.#failures = 0;
    // Isovalues are values of the previous volume.
    this.#surfaces = null;
    this.#close();
    void this.#add();
    this.#host?.wake();
  }

  /** Null while it is not in a picture. */
  get layer(): Layer | null {
    return this.#layer;
  }

  get info(): StoreInfo | null {
    return this.#info;
  }

  /** The reason why the layer cannot be shown at present. */
  get presentFault(): Error | null {
    return this.#fault;
  }

  // ---- Its properties ----

  get surfaces(): readonly Surface[] {
    return this.#surfaces ?? this.#defaults();
  }

  /** Null if the attributes, or else the store, determine them. */
  setSurfaces(surfaces: readonly Surface[] | null): void {
    const before = this.surfaces;
    this.#surfaces = surfaces && [...surfaces];
    if (this.#layer && !sameValue(this.surfaces, this.#layer.surfaces)) {
      this.#layer.surfaces = this.surfaces;
    }
    this.#reportIsovalues(before);
    this.#host?.wake();
  }

  setIsovalues(isovalues: readonly number[] | null): void {
    if (!isovalues) {
      this.setSurfaces(null);
      return;
    }
    const { surfaces } = this;
    const defaults = surfacesOf(this.#element, isovalues, this.#colourNumber);
    this.setSurfaces(
      defaults.map((surface, i) => ({
        ...(surfaces[i] ?? surface),
        isovalue: surface.isovalue,
      })),
    );
  }

  /** The surfaces of the attributes, otherwise one at the store's first suggestion. */
  #defaults(): readonly Surface[] {
    const info = this.#info;
    const isovalues = isovaluesOf(this.#element) ?? (info ? [firstSurface(info).isovalue] : []);
    return surfacesOf(this.#element, isovalues, this.#colourNumber);
  }

  get transform(): Transform | null {
    return this.#transform ?? transformOf(this.#element) ?? null;
  }

  /** Null if the attribute determines it. Throws a RangeError. */
  setTransform(transform: Transform | null): void {
    const { layer } = this;
    const requested = transform ?? transformOf(this.#element) ?? identity;
    if (layer && !sameValue(layer.transform, requested)) layer.transform = requested;
    else if (!layer && transform) checkedTransform(transform);
    this.#transform = transform;
    this.#host?.wake();
  }

  get isVisible(): boolean {
    return this.#element.getAttribute("visible") !== "false";
  }

  /** The attributes of name, group or visibility have changed. */
  readAttributes(): void {
    const { layer } = this;
    if (!layer) return;
    const name = this.#element.getAttribute("name") ?? "";
    const group = this.#element.getAttribute("group") ?? "";
    if (layer.name !== name) layer.name = name;
    if (layer.group !== group) layer.group = group;
    layer.visible = this.isVisible;
    this.#host?.wake();
  }

  // ---- Its layer ----

  /** The child element was added to this `<isosplat-viewer>`. */
  enter(host: LayerPartHost): void {
    this.#close();
    this.#viewer = null;
    this.#host = host;
  }

  /** The child element was removed from this `<isosplat-viewer>`. It may already be in another one. */
  leave(host: LayerPartHost): void {
    if (host !== this.#host) return;
    this.#close();
    this.#viewer = null;
    this.#host = null;
  }

  /** Adds the layer to a viewer, whose other content is open. Resolves when its header was read, or after a fault. */
  show(viewer: Viewer): Promise<void> {
    this.#viewer = viewer;
    return this.#add();
  }

  /** The viewer closes all layers. */
  closing(): void {
    this.#layer = null;
    this.#viewer = null;
    this.#close();
  }

  /** The viewer has closed the layer. */
  closed(): void {
    this.#layer = null;
  }

  retry(): void {
    if (this.#fault && !this.#layer) void this.#add();
  }

  #close(): void {
    clearTimeout(this.#timer);
    this.#opening?.abort();
    this.#opening = null;
    this.#fault = null;
    const layer = this.#layer;
    this.#layer = null;
    layer?.remove();
  }

  async #add(): Promise<void> {
    const viewer = this.#viewer;
    const source = this.#source;
    if (!viewer || !source) return;
    this.#close();
    const opening = new AbortController();
    this.#opening = opening;
    const { signal } = opening;
    this.#colourNumber = this.#host?.colourNumber() ?? 0;
    const { surfaces, transform, isVisible } = this;
    source.forget();
    try {
      const layer = await viewer.addLayer(source, {
        name: this.#element.getAttribute("name") ?? "",
        group: this.#element.getAttribute("group") ?? "",
        visible: isVisible,
        ...(transform && { transform }),
        ...(surfaces.length > 0 && { surfaces }),
        signal,
      });
      if (signal.aborted) layer.remove();
      else this.#added(layer);
    } catch (error) {
      if (!signal.aborted) this.#failed(error);
    }
  }

  #added(layer: Layer): void {
    this.#layer = layer;
    this.#fault = null;
    this.#failures = 0;
    // Settings may have changed in the meantime.
    this.readAttributes();
    this.setTransform(this.#transform);
    this.#host?.added();
    this.#opened();
  }

  /** Called when the store may have been read. The store of a hidden layer is read when the layer is shown. */
  #opened(): void {
    const info = this.#layer?.info ?? null;
    if (!info || info === this.#info) return;
    const before = this.surfaces;
    this.#info = info;
    this.setSurfaces(this.#surfaces);
    this.#reportIsovalues(before);
    this.#report("opened", info);
  }

  #failed(error: unknown): void {
    const fault =
      error instanceof StreamError || error instanceof RendererError
        ? error
        : new RendererError(error instanceof Error ? error.message : String(error), "internal");
    this.fault(fault);
    if (faults[fault.kind].retry === "never") return;
    this.#timer = setTimeout(() => void this.#add(), slowWait(this.#failures++));
  }

  /** Reports a fault, also a later one of the open layer, which the viewer reports. */
  fault(error: StreamError | RendererError): void {
    this.#fault = error;
    this.#report("fault", error);
    this.#host?.fault(error);
  }

  /** A property of the layer has changed, by this element or by a program. */
  changed(property: LayerProperty): void {
    const layer = this.#layer;
    if (!layer) return;
    if (property === "surfaces" && this.#info && !sameValue(layer.surfaces, this.surfaces)) {
      this.setSurfaces(layer.surfaces);
    } else if (property === "transform" && !sameValue(layer.transform, this.transform)) {
      this.#transform = layer.transform;
    } else if (property === "visible" && layer.visible !== this.isVisible) {
      if (layer.visible) this.#element.removeAttribute("visible");
      else this.#element.setAttribute("visible", "false");
    } else if (property === "name" || property === "group") {
      const value = layer[property];
      if ((this.#element.getAttribute(property) ?? "") !== value) {
        this.#element.setAttribute(property, value);
      }
    }
  }

  /** The viewer reports progress: a layer that was hidden may be open now. */
  progressed(): void {
    this.#opened();
    if (this.#layer?.progress && !this.#layer.progress.fault) this.#fault = null;
  }

  #reportIsovalues(before: readonly Surface[]): void {
    const isovalues = this.surfaces.map(({ isovalue }) => isovalue);
    if (
      sameValue(
        isovalues,
        before.map(({ isovalue }) => isovalue),
      )
    )
      return;
    this.#report("isovaluechange", isovalues);
  }

  #report(name: string, detail: unknown): void {
    this.#element.dispatchEvent(new CustomEvent(name, { detail }));
  }
}
