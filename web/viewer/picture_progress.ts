import { CoalescedTask } from "../stream/coalesced_task.ts";
import type { Progress } from "../stream/types.ts";
import type { LayerList } from "./layer_list.ts";
import { progressOfShown } from "./layers_progress.ts";
import type { SampleBudget } from "./sample_budget.ts";

/**
 * The streaming progress of the picture: the sum over all its layers. It is computed once for all layers
 * whose progress changes at the same time.
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

  /** Whether a change of a layer's progress is still to be reported. */
  get isPending(): boolean {
    return this.#summing.isRequested;
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

  /** Cancels the pending report. */
  cancel(): void {
    this.#summing.cancel();
  }

  /** Null while no layer has reported progress. The last progress is then kept. */
  #sum(): Progress | null {
    return progressOfShown(this.#list.entries, this.#samples.samples);
  }
}
