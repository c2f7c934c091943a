import { type LayerEntry, type LayerList, placedOf } from "./layer_list.ts";
import type { RendererModule } from "./renderer_module.ts";

/** The volumes of layers in the renderer, which is replaced after a failure. */
export class LayerVolumes {
  readonly #list: LayerList;
  /** The volumes that each renderer has. */
  readonly #numbers = new WeakMap<RendererModule, Set<number>>();

  constructor(list: LayerList) {
    this.#list = list;
  }

  /**
   * A layer was opened. Gives the renderer, which may be another one, the volumes of all layers, and
   * takes all others away.
   */
  opened(entry: LayerEntry, renderer: RendererModule): void {
    const present = this.#numbers.get(renderer) ?? new Set<number>();
    this.#numbers.set(renderer, present);
    for (const number of [...present]) {
      if (this.#list.entries.some(({ layer }) => layer.id === number)) continue;
      renderer.volume(number).remove();
      present.delete(number);
    }
    for (const each of this.#list.entries) {
      const info = placedOf(each);
      const { id } = each.layer;
      if (!info || (each !== entry && present.has(id))) continue;
      renderer.volume(id).open(info);
      present.add(id);
    }
    this.applySurfaces(entry, renderer);
  }

  applySurfaces({ layer }: LayerEntry, renderer: RendererModule): void {
    renderer.volume(layer.id).setSurfaces(layer.visible ? layer.surfaces : []);
  }

  /** A layer's volume is removed from the renderer by the caller. */
  forget({ layer }: LayerEntry, renderer: RendererModule): void {
    this.#numbers.get(renderer)?.delete(layer.id);
  }
}
