import { CoalescedTask } from "../stream/coalesced_task.ts";
import type { Progress } from "../stream/types.ts";
import type { LayerList } from "./layer_list.ts";
import { progressOfShown } from "./layers_progress.ts";
import type { SampleBudget } from "./sample_budget.ts";

/**
 * The streaming progress of the picture. That of many layers is the sum of theirs, so it is found once for
 * all layers that change together.
 */
export class PictureProgress {
  readonly #list: LayerList;
  readonly #samples: SampleBudget;
  readonly #report: (progress: Progress) => void;
  readonly #summing = new CoalescedTask(() => this.update());
  #progress: Progress | null = null;

  constructor(list: LayerList, samples: SampleBudget, report: (progress: Progress) => void) {
    this.#list = list;
    this.#samples = samples;
    this.#report = report;
  }

  /** Viewer.progress. */
  get progress(): Progress | null {
    return (this.#summing.isRequested && this.#sum()) || this.#progress;
  }

  /** The progress of one layer has changed. */
  layerChanged(): void {
    if (this.#list.entries.length > 1) this.#summing.request();
    else this.update();
  }

  update(): void {
    this.#summing.cancel();
    const progress = this.#sum();
    if (!progress) return;
    this.#progress = progress;
    this.#report(progress);
  }

  /** No report follows from changes until now. */
  cancel(): void {
    this.#summing.cancel();
  }

  /** Null while nothing is known of any layer: the progress stays what it was. */
  #sum(): Progress | null {
    return progressOfShown(this.#list.entries, this.#samples.samples);
  }
}
