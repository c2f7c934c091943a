import type { Upload } from "./frame_scheduler_host.ts";
import { type LayerEntry, type LayerList, placedOf, volumesOf } from "./layer_list.ts";
import type { OpenVolume } from "./open_volume.ts";
import { RendererError } from "./renderer_error.ts";
import type { RendererModule } from "./renderer_module.ts";

/** The volumes of layers in the renderer, which is replaced after a failure. */
export class LayerVolumes {
  readonly #list: LayerList;
  /** The volumes that each renderer has. */
  readonly #numbers = new WeakMap<RendererModule, Set<number>>();
  /** Whether a renderer may have volumes that have been closed, or lack some. */
  #isStale = false;

  constructor(list: LayerList) {
    this.#list = list;
  }

  /**
   * A volume of a layer was opened. Passes the volumes of all layers to the renderer, which may be another one than
   * before, and removes all others from it.
   */
  opened(entry: LayerEntry, volume: OpenVolume, renderer: RendererModule): void {
    const present = this.#numbers.get(renderer) ?? new Set<number>();
    this.#numbers.set(renderer, present);
    if (present.size === 0) this.#isStale = true;
    if (this.#isStale) this.#openAll(present, volume, renderer);
    else this.#openOne(present, entry, volume, renderer);
    this.#isStale = false;
    if (entry.volume === volume) this.applySurfaces(entry, renderer);
  }

  /** Volumes were closed, but not removed from the renderer. They are removed when the next volume is opened. */
  closed(): void {
    this.#isStale = true;
  }

  /** Passes to the renderer all volumes that it lacks, and `opened` in any case. Removes all others. */
  #openAll(present: Set<number>, opened: OpenVolume, renderer: RendererModule): void {
    const wanted = this.#list.entries.flatMap((each) =>
      volumesOf(each).map((own) => ({ entry: each, volume: own })),
    );
    const numbers = new Set(wanted.map((each) => each.volume.number));
    for (const number of [...present]) {
      if (numbers.has(number)) continue;
      renderer.volume(number).remove();
      present.delete(number);
    }
    for (const each of wanted) {
      if (each.volume !== opened && present.has(each.volume.number)) continue;
      this.#openOne(present, each.entry, each.volume, renderer);
    }
  }

  /** Does nothing for a volume whose store is not open. */
  #openOne(
    present: Set<number>,
    entry: LayerEntry,
    volume: OpenVolume,
    renderer: RendererModule,
  ): void {
    const info = placedOf(entry, volume);
    if (!info) return;
    renderer.volume(volume.number).open(info);
    present.add(volume.number);
  }

  /** Sets the surfaces of the volume that is shown. The other volumes of the layer have none. */
  applySurfaces({ layer, volume }: LayerEntry, renderer: RendererModule): void {
    renderer.volume(volume.number).setSurfaces(layer.visible ? layer.surfaces : []);
  }

  /** The layer's transform has changed. */
  move(entry: LayerEntry, renderer: RendererModule): void {
    for (const volume of volumesOf(entry)) {
      const info = placedOf(entry, volume);
      const isPresent = this.#numbers.get(renderer)?.has(volume.number);
      if (info && isPresent) renderer.volume(volume.number).move(info);
    }
  }

  /** Removes volumes from the renderer. */
  remove(volumes: readonly OpenVolume[], renderer: RendererModule): void {
    for (const { number } of volumes) {
      if (this.#numbers.get(renderer)?.delete(number)) renderer.volume(number).remove();
    }
  }

  /** Checks that these uploads, and all before, have succeeded. Notifies the volumes of those that have failed. */
  checkGpu(renderer: RendererModule, uploads: readonly Upload[]): void {
    try {
      renderer.checkGpu();
    } catch (error) {
      if (!(error instanceof RendererError) || error.kind !== "out-of-memory") throw error;
      for (const volume of this.#list.entries.flatMap(volumesOf)) {
        const own = uploads.filter((each) => each.volume === volume.number);
        const idsOf = (what: Upload["of"]) =>
          own.filter(({ of }) => of === what).map(({ id }) => id);
        volume.rejectUploads(idsOf("samples"), idsOf("field"), error);
      }
    }
  }
}
