import type { StoreInfo } from "../core/types.ts";
import { sameNumbers } from "../stream/same_numbers.ts";
import type { LayerEntry, LayerList } from "./layer_list.ts";
import { type SampleNeed, shareSamples } from "./sample_shares.ts";
import { coverage, type Transform, viewProjectionOf } from "./transform.ts";

/** The budget is divided again only if a share changes by more than this fraction of its present size. */
const smallestChange = 0.1;

/** The fraction of the share of a layer with steps that is for the steps that are not shown. */
const shareOfOthers = 0.5;

/** The number of samples in a layer's share that is for the steps that are not shown. */
export function samplesOfOthers({ samples, steps }: Pick<LayerEntry, "samples" | "steps">): number {
  return steps ? Math.floor(shareOfOthers * samples) : 0;
}

/** The share of the view that a layer's volume covers, with the arguments from which it was computed. */
interface Covered {
  info: StoreInfo;
  transform: Transform;
  share: number;
}

/** The sample budget of a viewer, which its layers share. */
export class SampleBudget {
  readonly #list: LayerList;
  #samples: number;
  #viewProjection: Float64Array | null = null;
  /** Computed for the present view. */
  #coverages = new WeakMap<LayerEntry, Covered>();
  /** The shares of these layers until the next division. Many layers of a scene are opened at the same time. */
  #opening: { of: readonly LayerEntry[]; shares: Map<LayerEntry, number> } | null = null;

  constructor(samples: number, list: LayerList) {
    this.#samples = samples;
    this.#list = list;
  }

  /** The whole budget. */
  get samples(): number {
    return this.#samples;
  }

  /** Viewer.setSampleBudget. */
  set(samples: number): void {
    this.#samples = samples;
    this.share(true);
  }

  /** Sets the view that is drawn at rest. Layers that cover more of it get more of the sample budget. */
  viewed(viewProjection: Float64Array): void {
    const isOther = !this.#viewProjection || !sameNumbers(viewProjection, this.#viewProjection);
    if (isOther) this.#coverages = new WeakMap();
    this.#viewProjection = viewProjection;
    if (this.#list.entries.length > 1) this.share();
  }

  /** The share of a layer that is being opened. */
  shareOf(entry: LayerEntry): number {
    const of = this.#list.entries;
    if (this.#opening?.of !== of || !this.#opening.shares.has(entry)) {
      const sharing = of.filter((each) => each === entry || each.layer.visible);
      const shares = this.#sharesOf(sharing);
      this.#opening = { of, shares: new Map(sharing.map((each, i) => [each, shares[i] ?? 0])) };
    }
    return this.#opening.shares.get(entry) ?? this.#samples;
  }

  #sharesOf(entries: readonly LayerEntry[]): number[] {
    return shareSamples(
      this.#samples,
      entries.map((entry) => this.#need(entry)),
    );
  }

  #coverage(entry: LayerEntry): number {
    const { info } = entry.volume;
    const { transform } = entry.layer;
    const view = this.#viewProjection;
    if (!info || !view) return 1;
    const known = this.#coverages.get(entry);
    if (known?.info === info && known.transform === transform) return known.share;
    const share = coverage(info, viewProjectionOf(view, transform));
    this.#coverages.set(entry, { info, transform, share });
    return share;
  }

  #need(entry: LayerEntry): SampleNeed {
    const { layer, volume } = entry;
    return {
      pinned: volume.session?.pinnedSamples ?? 0,
      coverage: this.#coverage(entry),
      surfaces: layer.surfaces.filter(({ opacity }) => opacity > 0).length,
    };
  }

  /**
   * Divides the budget again. Either all shares change or none, so that their sum stays within the budget.
   * `isOtherBudget`: changes them even if the differences are small.
   */
  share(isOtherBudget = false): void {
    this.#opening = null;
    const sharing = this.#list.entries.filter(({ volume }) => volume.session);
    const shares = this.#sharesOf(sharing);
    const isOther = sharing.some(({ samples }, i) => {
      const change = Math.abs((shares[i] ?? 0) - samples);
      return change > (sharing.length > 1 ? smallestChange * samples : 0);
    });
    if (!isOther && !isOtherBudget) return;
    sharing.forEach((entry, i) => {
      entry.samples = shares[i] ?? 0;
      entry.volume.session?.setSampleBudget(entry.samples - samplesOfOthers(entry));
    });
  }
}
