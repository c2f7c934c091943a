import { fieldOpeningBytes } from "../stream/field_source.ts";
import type { CameraView } from "../stream/types.ts";
import type { LayerEntry } from "./layer_list.ts";
import type { OpenVolume } from "./open_volume.ts";
import {
  activeCells,
  costOfLayers,
  fieldShare,
  type PlayCost,
  playCost,
  type StepCost,
} from "./time_cost.ts";
import { completeCosts } from "./time_plan.ts";

/** Bytes and samples of one step of a layer. */
export interface StepNeed {
  bytes: number;
  /** The bytes of the coarse levels, which are fetched when a store is opened. */
  coarseBytes: number;
  samples: number;
}

interface LayerCosts {
  /** The isovalues and the field for which the costs were computed. */
  shown: string;
  steps: Map<number, StepCost>;
}

/** The bytes and samples of the steps whose stores have been opened. */
export class StepCosts {
  readonly #layers = new WeakMap<LayerEntry, LayerCosts>();
  readonly #shownField: () => string | null;

  /** `shownField`: the name of the field that colours show. */
  constructor(shownField: () => string | null) {
    this.#shownField = shownField;
  }

  /** Notes the cost of a step whose store is open. */
  note(entry: LayerEntry, step: number, { session, info }: OpenVolume): void {
    if (!session || !info) return;
    const { steps } = this.#of(entry);
    if (steps.get(step)?.bytes !== undefined) return;
    const isovalues = isovaluesOf(entry);
    const [finest] = session.levelCosts(isovalues);
    const share = fieldShare(info, session.shownField?.info);
    const bytes = finest?.level === 0 ? withField(finest.bytes, share) : undefined;
    steps.set(step, { bytes, cells: cellsOf(isovalues, info), isEstimated: share > 0 });
  }

  /** The bytes of all steps of layers at full detail. */
  total(entries: readonly LayerEntry[], count: number): PlayCost | undefined {
    return costOfLayers(
      entries.map((entry) => {
        const { steps } = this.#of(entry);
        const none: StepCost = { bytes: undefined, cells: undefined };
        return playCost(Array.from({ length: count }, (_, step) => steps.get(step) ?? none));
      }),
    );
  }

  #of(entry: LayerEntry): LayerCosts {
    const shown = `${isovaluesOf(entry)} ${this.#shownField() ?? ""}`;
    let costs = this.#layers.get(entry);
    if (costs?.shown !== shown) {
      costs = { shown, steps: new Map() };
      this.#layers.set(entry, costs);
    }
    return costs;
  }
}

function withField(bytes: number, share: number): number {
  return Math.round(bytes * (1 + share));
}

/** The isovalues of a layer's visible surfaces. */
export function isovaluesOf({ layer }: LayerEntry): number[] {
  return layer.surfaces.map(({ isovalue }) => isovalue);
}

function cellsOf(isovalues: readonly number[], info: NonNullable<OpenVolume["info"]>) {
  const cells = isovalues.map((isovalue) => activeCells(info, isovalue));
  return cells.reduce(
    (sum, each) => (sum === undefined || each === undefined ? undefined : sum + each),
    0,
  );
}

/**
 * The bytes and samples that a view needs of one step, in addition to the coarse levels. They are computed for the
 * step that is shown. Undefined if that step is not open.
 */
export function needOf(entry: LayerEntry, view: CameraView): StepNeed | undefined {
  const { session, info } = entry.volume;
  if (!session || !info) return undefined;
  const isovalues = isovaluesOf(entry);
  const known = session.levelCosts(isovalues);
  const costs = completeCosts(known, session.finestCoarseLevel, cellsOf(isovalues, info));
  const level = session.finestLevelOf(view);
  const cost = costs.find((each) => each.level === level);
  const field = session.shownField?.info;
  const samples = session.pinnedSamples + (cost?.cells ?? 0);
  return {
    bytes: withField(cost?.bytes ?? 0, fieldShare(info, field)),
    coarseBytes: session.firstCoarseBytes + (field ? Math.min(field.bytes, fieldOpeningBytes) : 0),
    // The values of a field take as much memory as the samples, and the session divides its budget.
    samples: field ? 2 * samples : samples,
  };
}
