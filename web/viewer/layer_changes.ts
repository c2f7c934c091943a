import { CoalescedTask } from "../stream/coalesced_task.ts";
import { type LayerList, manyLayers } from "./layer_list.ts";
import type { OpenVolume } from "./open_volume.ts";

/**
 * Notifies the layers of changes of other layers. Many layers of a scene may change at the same time, so their
 * changes are combined into one notification.
 */
export class LayerChanges {
  readonly #list: LayerList;
  readonly #opened: CoalescedTask;
  /** The volumes whose visible chunks have changed since the last notification. */
  readonly #changed = new Set<OpenVolume>();
  readonly #telling = new CoalescedTask(() => this.#tell());

  /** `opened` is called once after one or more layers were opened, to divide the sample budget again. */
  constructor(list: LayerList, opened: () => void) {
    this.#list = list;
    this.#opened = new CoalescedTask(() => {
      const { sessions } = list;
      if (sessions.length > 1) for (const session of sessions) session.sceneChanged();
      // Layers are tested one after the other, and again when another one has changed the picture.
      if (sessions.length > manyLayers) for (const session of sessions) session.fetchOccluded();
      opened();
    });
  }

  /** A layer was opened. */
  opened(): void {
    this.#opened.request();
  }

  /** The visible chunks of a volume have changed, so they may occlude other regions of the other volumes. */
  visible(volume: OpenVolume): void {
    if (this.#list.entries.length <= 1) return;
    this.#changed.add(volume);
    this.#telling.request();
  }

  cancel(): void {
    this.#opened.cancel();
    this.#telling.cancel();
    this.#changed.clear();
  }

  #tell(): void {
    const [first] = this.#changed;
    const only = this.#changed.size === 1 ? first?.session : undefined;
    this.#changed.clear();
    for (const session of this.#list.sessions) {
      if (session !== only) session.otherPictureChanged();
    }
  }
}
