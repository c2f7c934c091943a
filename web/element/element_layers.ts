import type { StreamError } from "../stream/types.ts";
import type { RendererError } from "../viewer/renderer_error.ts";
import type { Viewer } from "../viewer/viewer.ts";
import { layerPartOf } from "./isosplat_layer.ts";
import type { LayerPart, LayerPartHost } from "./layer_part.ts";

/** The functions that the layers of an element need from it. */
export interface ElementLayersHost {
  /** A layer was added to the viewer. */
  added(viewer: Viewer): void;
  fault(error: StreamError | RendererError): void;
  /** Child elements were added or removed, or have changed: requests a draw. */
  wake(): void;
}

/** The `<isosplat-layer>` children of an element, as layers of its viewer. */
export class ElementLayers {
  readonly #element: Element;
  readonly #host: ElementLayersHost;
  readonly #observer: MutationObserver;
  #parts: readonly LayerPart[] = [];
  readonly #hosts = new WeakMap<LayerPart, LayerPartHost>();
  #viewer: Viewer | null = null;
  /** The number of visible layers in the viewer that do not belong to child elements. */
  #others = 0;

  constructor(element: Element, host: ElementLayersHost) {
    this.#element = element;
    this.#host = host;
    this.#observer = new MutationObserver(() => this.#read());
  }

  /** Whether a child element has something to show. */
  get hasAny(): boolean {
    return this.#parts.some(({ source }) => source !== null);
  }

  /** The reason why one of the layers cannot be shown. Undefined if all can be shown. */
  get presentFault(): Error | undefined {
    return this.#parts.find(({ presentFault }) => presentFault)?.presentFault ?? undefined;
  }

  /** The element was added to a document. */
  attach(): void {
    this.#observer.observe(this.#element, { childList: true });
    this.#read();
  }

  /** The element was removed from its document. */
  detach(): void {
    this.#observer.disconnect();
    for (const part of this.#parts) this.#leave(part);
    this.#parts = [];
  }

  /** Follows the events of a new viewer. */
  listen(viewer: Viewer): void {
    viewer.on("layeradd", () => this.#order(viewer));
    viewer.on("layerremove", (layer) => this.#partOf(layer)?.closed());
    viewer.on("layerchange", ({ layer, property }) => this.#partOf(layer)?.changed(property));
    viewer.on("layererror", ({ layer, error }) => {
      const part = this.#partOf(layer);
      if (part) part.fault(error);
      else this.#host.fault(error);
    });
    viewer.on("progress", () => {
      for (const part of this.#parts) part.progressed();
    });
  }

  /** Adds the layers to a viewer, whose other content is open. Resolves when each layer is open or has failed. */
  async show(viewer: Viewer): Promise<void> {
    this.#viewer = viewer;
    this.#others = viewer.layers.filter(({ visible }) => visible).length;
    await Promise.all(this.#parts.map((part) => part.show(viewer)));
  }

  /** The viewer is closed, or opens other content. */
  hide(): void {
    this.#viewer = null;
    for (const part of this.#parts) part.closing();
  }

  retry(): void {
    for (const part of this.#parts) part.retry();
  }

  #partOf(layer: object): LayerPart | undefined {
    return this.#parts.find((part) => part.layer === layer);
  }

  #read(): void {
    const parts = [...this.#element.children].flatMap((child) => layerPartOf(child) ?? []);
    const before = new Set(this.#parts);
    this.#parts = parts;
    for (const part of parts) {
      if (before.delete(part)) continue;
      const host = this.#partHost(part);
      this.#hosts.set(part, host);
      part.enter(host);
      if (this.#viewer) void part.show(this.#viewer);
    }
    for (const part of before) this.#leave(part);
    if (this.#viewer) this.#order(this.#viewer);
    this.#host.wake();
  }

  #leave(part: LayerPart): void {
    const host = this.#hosts.get(part);
    if (host) part.leave(host);
  }

  #partHost(part: LayerPart): LayerPartHost {
    return {
      added: () => {
        if (!this.#viewer) return;
        this.#order(this.#viewer);
        this.#host.added(this.#viewer);
      },
      fault: (error: StreamError | RendererError) => this.#host.fault(error),
      colourNumber: () => {
        const at = this.#parts.indexOf(part);
        return this.#others + this.#parts.slice(0, at).filter(({ isVisible }) => isVisible).length;
      },
      wake: () => this.#host.wake(),
    };
  }

  /** Lists the layers in the order of the elements, after all others. */
  #order(viewer: Viewer): void {
    const wanted = this.#parts.flatMap(({ layer }) => layer ?? []);
    let { layers } = viewer;
    const first = layers.length - wanted.length;
    for (const [i, layer] of wanted.entries()) {
      if (layers[first + i] === layer) continue;
      viewer.moveLayer(layer, first + i);
      layers = viewer.layers;
    }
  }
}
