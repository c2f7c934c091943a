import { CoalescedTask } from "../stream/coalesced_task.ts";
import type { LayerList } from "./layer_list.ts";
import type { OpenVolume } from "./open_volume.ts";

/**
 * Layers are tested for occlusion one after the other, and again when another one has changed the picture. Of
 * more layers than these, all chunks are fetched.
 */
const maxTested = 16;

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
      const { sessions } = list;
      for (const session of sessions) session.sceneChanged();
      if (sessions.length > maxTested) for (const session of sessions) session.fetchOccluded();
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
