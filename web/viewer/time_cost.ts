import { activeCellsAt, type CellStatistics } from "../core/active_cells.ts";
import type { FieldInfo } from "../core/types.ts";

/** The bytes that all steps take at full detail. */
export interface PlayCost {
  steps: number;
  bytes: number;
  /** Whether the bytes of some steps are estimated, from their headers or from other steps. */
  isEstimated: boolean;
}

/** The known numbers of one step of one layer. */
export interface StepCost {
  /** The bytes of its surfaces, with a field; undefined until its directory has been fetched. */
  bytes: number | undefined;
  /** Part of these bytes is estimated: those of a field. */
  isEstimated?: boolean;
  /** The cells of its surfaces, according to its header: activeCells. */
  cells: number | undefined;
}

/**
 * The bytes of all steps of a layer. For steps whose bytes are unknown, they are estimated from the number of
 * cells, or otherwise by the mean of the known steps. Undefined if the bytes of no step are known.
 */
export function playCost(steps: readonly StepCost[]): PlayCost | undefined {
  const known = steps.filter(({ bytes }) => bytes !== undefined);
  if (known.length === 0) return undefined;
  const knownBytes = sum(known.map(({ bytes }) => bytes));
  const counted = known.filter(({ cells }) => cells !== undefined && cells > 0);
  const cells = sum(counted.map((step) => step.cells));
  const bytesPerCell = cells > 0 ? sum(counted.map(({ bytes }) => bytes)) / cells : undefined;
  const estimates = steps.map((step) => {
    if (step.bytes !== undefined) return step.bytes;
    if (step.cells !== undefined && bytesPerCell !== undefined) return step.cells * bytesPerCell;
    return undefined;
  });
  const estimated = estimates.filter((bytes) => bytes !== undefined);
  const mean = estimated.length > 0 ? sum(estimated) / estimated.length : knownBytes / known.length;
  return {
    steps: steps.length,
    bytes: Math.round(sum(estimates.map((bytes) => bytes ?? mean))),
    isEstimated: known.length < steps.length || known.some((step) => step.isEstimated),
  };
}

/**
 * The bytes of a field's chunks, relative to those of the store's chunks with the same cells: on average over the
 * file, because a field's directory is fetched only with its values. 0: no field is shown.
 */
export function fieldShare(
  { fileBytes, fields }: { fileBytes: number; fields: readonly Pick<FieldInfo, "bytes">[] },
  shown: Pick<FieldInfo, "bytes"> | undefined,
): number {
  // The file of a store includes its fields.
  const storeBytes = fileBytes - sum(fields.map(({ bytes }) => bytes));
  return shown && storeBytes > 0 ? shown.bytes / storeBytes : 0;
}

/** The cost of several layers that play together. Undefined if the cost of one of them is unknown. */
export function costOfLayers(costs: readonly (PlayCost | undefined)[]): PlayCost | undefined {
  const [first] = costs;
  if (!first || costs.some((cost) => !cost)) return undefined;
  return {
    steps: first.steps,
    bytes: sum(costs.map((cost) => cost?.bytes)),
    isEstimated: costs.some((cost) => cost?.isEstimated),
  };
}

/**
 * The number of cells of level 0 that an isovalue has, according to the store's header. 0 outside of its
 * statistics; undefined if it has none.
 */
export function activeCells(info: CellStatistics, isovalue: number): number | undefined {
  const bins = info.metadata.active_cells;
  if (!bins || bins.counts.length === 0 || !(bins.high > bins.low)) return undefined;
  return activeCellsAt(info, isovalue) ?? 0;
}

function sum(numbers: readonly (number | undefined)[]): number {
  return numbers.reduce<number>((all, each) => all + (each ?? 0), 0);
}
