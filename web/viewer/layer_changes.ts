import { CoalescedTask } from "../stream/coalesced_task.ts";
import type { LayerList } from "./layer_list.ts";
import type { OpenVolume } from "./open_volume.ts";

/**
 * Tells the layers what others have changed. Of a scene with many layers, many change together, so each is
 * told once for all of them.
 */
export class LayerChanges {
  readonly #list: LayerList;
  readonly #opened: CoalescedTask;
  /** The volumes that show other chunks, until the others are told. */
  readonly #changed = new Set<OpenVolume>();
  readonly #telling = new CoalescedTask(() => this.#tell());

  /** `opened`: layers were opened, and share with the others. */
  constructor(list: LayerList, opened: () => void) {
    this.#list = list;
    this.#opened = new CoalescedTask(() => {
      for (const session of list.sessions) session.sceneChanged();
      opened();
    });
  }

  /** A layer was opened. */
  opened(): void {
    this.#opened.request();
  }

  /** A volume shows other chunks: regions of others may be visible now, or no longer. */
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
