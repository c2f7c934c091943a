import type { Layer } from "../../viewer/layer.ts";

/** Shows one layer alone, and later the layers that were visible before. */
export class Solo {
  #before: ReadonlyMap<Layer, boolean> | null = null;

  /** Call it when the visitor has shown or hidden layers in another way. */
  forget(): void {
    this.#before = null;
  }

  /** Whether this layer is shown alone by `toggle`. */
  isAlone(layer: Layer, layers: readonly Layer[]): boolean {
    return this.#before !== null && layers.every((each) => each.visible === isOf(layer, each));
  }

  /** Hides all other layers. If `isAlone`, shows the layers that were visible before. */
  toggle(layer: Layer, layers: readonly Layer[]): void {
    const before = this.isAlone(layer, layers) ? this.#before : null;
    this.#before = before
      ? null
      : (this.#before ?? new Map(layers.map((each) => [each, each.visible])));
    for (const each of layers)
      each.visible = before ? (before.get(each) ?? true) : isOf(layer, each);
  }
}

/** Whether a layer is shown with the one that is shown alone. */
function isOf(layer: Layer, each: Layer): boolean {
  return each === layer || each.sharesVolumeWith(layer);
}
