import type { StoreInfo } from "../core/types.ts";
import type { Source } from "../stream/source.ts";
import type { Layer } from "../viewer/layer.ts";
import type { Transform } from "../viewer/transform.ts";
import type { Surface } from "../viewer/types.ts";
import { expected, transformOf } from "./element_attributes.ts";
import type { IsosplatLayerEvents } from "./element_events.ts";
import { sourceOf } from "./element_source.ts";
import { EventElement } from "./event_element.ts";
import { LayerPart } from "./layer_part.ts";

/** Properties that may have been set before the element was defined. */
const ownProperties = "src source name group surfaces isovalues visible transform".split(" ");

const parts = new WeakMap<Element, LayerPart>();

/** What an element shows; undefined if it is not an `<isosplat-layer>`. */
export function layerPartOf(element: Element): LayerPart | undefined {
  return parts.get(element);
}

/**
 * A further volume in the picture of the enclosing `<isosplat-viewer>`, with its surfaces and its place.
 *
 *     <isosplat-viewer src="head.isosplat" isovalue="60.5">
 *       <isosplat-layer src="dose.isosplat" isovalue="20" colour="d55e00" opacity="0.4"></isosplat-layer>
 *     </isosplat-viewer>
 *
 * Layers may be added, removed, moved and changed at any time. Their order is that of the elements, after the
 * layers of `src` or `scene`. In a scene that changes with time, the layer is the same at every step.
 *
 * @attr {string} src - The address of a store, or of a volume of a server, as that of `<isosplat-viewer>`.
 * @attr {string} name - A name for people.
 * @attr {string} group - The name of the layer's group, for people.
 * @attr {string} isovalue - One or more isovalues, with commas. Default: the volume's first suggestion. The element does not change it.
 * @attr {string} colour - The colours of the surfaces: `d9ccb3,c8553d`. Default: another colour for each layer.
 * @attr {string} opacity - The opacities of the surfaces, 0 to 1: `0.4,1`.
 * @attr {string} visible - `false` hides the layer. A hidden layer fetches nothing.
 * @attr {string} transform - An affine transform of the volume's world into that of the picture: 16 numbers with commas, a matrix row by row, whose last row is 0,0,0,1. Default: none.
 *
 * @fires {CustomEvent<StoreInfo>} opened - The volume is open. Its first surface follows.
 * @fires {CustomEvent<readonly number[]>} isovaluechange - The isovalues have changed.
 * @fires {CustomEvent<StreamError | RendererError>} fault - The layer cannot be shown, or not completely. The other layers go on. `<isosplat-viewer>` reports it, too.
 */
export class IsosplatLayerElement extends EventElement<IsosplatLayerEvents> {
  static readonly observedAttributes = [
    "src",
    "name",
    "group",
    "isovalue",
    "colour",
    "opacity",
    "visible",
    "transform",
  ];

  readonly #part = new LayerPart(this);

  constructor() {
    super();
    parts.set(this, this.#part);
  }

  connectedCallback(): void {
    this.takeProperties(ownProperties);
  }

  attributeChangedCallback(name: string, before: string | null, now: string | null): void {
    if (before === now) return;
    if (name === "src") this.#part.setSource(now === null ? null : this.#sourceOf(now));
    else if (name === "transform") this.#readTransform(now);
    else if (name === "isovalue" || name === "colour" || name === "opacity") {
      this.#part.setSurfaces(null);
    } else this.#part.readAttributes();
  }

  /** The address of the volume: the attribute. */
  get src(): string {
    return this.getAttribute("src") ?? "";
  }
  set src(value: string | null | undefined) {
    this.setText("src", value);
  }

  /** The source of the bytes. Set it instead of `src` for requests with tokens and headers. */
  get source(): Source | null {
    return this.#part.source;
  }
  set source(source: Source | null | undefined) {
    this.#part.setSource(source ?? null);
  }

  /** A name for people: the attribute. */
  get name(): string {
    return this.getAttribute("name") ?? "";
  }
  set name(value: string | null | undefined) {
    this.setText("name", value);
  }

  /** The name of the layer's group, for people: the attribute. */
  get group(): string {
    return this.getAttribute("group") ?? "";
  }
  set group(value: string | null | undefined) {
    this.setText("group", value);
  }

  /** Whether the layer is shown: false if the attribute is `false`. */
  get visible(): boolean {
    return this.#part.isVisible;
  }
  set visible(value: boolean | null | undefined) {
    this.setText("visible", value === false ? "false" : null);
  }

  /**
   * The isovalues. New ones keep the colours of the existing surfaces. Null or undefined: those of
   * the attribute, else the volume's first suggestion.
   */
  get isovalues(): readonly number[] {
    return this.surfaces.map(({ isovalue }) => isovalue);
  }
  set isovalues(requested: readonly number[] | null | undefined) {
    this.#part.setIsovalues(requested ?? null);
  }

  /** The isosurfaces with their colours and opacities. Null or undefined: those of the attributes. */
  get surfaces(): readonly Surface[] {
    return this.#part.surfaces;
  }
  set surfaces(requested: readonly Surface[] | null | undefined) {
    this.#part.setSurfaces(requested ?? null);
  }

  /**
   * An affine transform, 16 numbers row by row. Null or undefined: that of the attribute. Throws a
   * RangeError if it is not affine, or makes volumes flat.
   */
  get transform(): Transform | null {
    return this.#part.transform;
  }
  set transform(requested: Transform | null | undefined) {
    this.#part.setTransform(requested ?? null);
  }

  /** The open volume; null before the first. */
  get info(): StoreInfo | null {
    return this.#part.info;
  }

  /** The layer of `viewer.layers`; null while there is none. */
  get layer(): Layer | null {
    return this.#part.layer;
  }

  #readTransform(text: string | null): void {
    if (transformOf(this) !== undefined) this.#part.setTransform(null);
    else {
      const what = "16 numbers of an affine transform, row by row, the last row 0,0,0,1";
      this.#part.fault(expected("transform", text ?? "", what));
    }
  }

  #sourceOf(src: string): Source | null {
    const source = sourceOf(src, document.baseURI);
    if (!source) this.#part.fault(expected("src", src, "the http or https address of a store"));
    return source ?? null;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "isosplat-layer": IsosplatLayerElement;
  }
}

if (typeof customElements !== "undefined" && !customElements.get("isosplat-layer")) {
  customElements.define("isosplat-layer", IsosplatLayerElement);
}
