import type { Layer } from "../../viewer/layer.ts";

/** Shows one layer alone, and then what was visible before. */
export class Solo {
  #before: ReadonlyMap<Layer, boolean> | null = null;

  /** What is visible was chosen otherwise. */
  forget(): void {
    this.#before = null;
  }

  /** Whether this layer is shown alone by `toggle`. */
  isAlone(layer: Layer, layers: readonly Layer[]): boolean {
    return this.#before !== null && layers.every((each) => each.visible === (each === layer));
  }

  /** Hides all others; if they are hidden by this, shows what was visible before. */
  toggle(layer: Layer, layers: readonly Layer[]): void {
    const before = this.isAlone(layer, layers) ? this.#before : null;
    this.#before = before
      ? null
      : (this.#before ?? new Map(layers.map((each) => [each, each.visible])));
    for (const each of layers) each.visible = before ? (before.get(each) ?? true) : each === layer;
  }
}
