import { activeCellsAt } from "../../core/active_cells.ts";
import type { Bins, StoreInfo } from "../../core/types.ts";

/** A tissue of computed tomography. */
export type Tissue = "skin" | "bone";

/** An isovalue that the page offers. */
export interface IsovalueChoice {
  isovalue: number;
  /** The tissue whose surface it conventionally shows. */
  tissue?: Tissue;
  /** The distance from the mean in standard deviations, by which isovalues of density maps are stated. */
  deviations?: number;
}

/** More would not fit into a row of pictures. */
const mostChoices = 4;

/**
 * The conventional isovalue of each tissue in Hounsfield units, and the range that counts as near: air has −1000,
 * fat −100, and soft tissue 40; bone begins at 150 to 300, and teeth and metal have more than 1000.
 */
const tissues: Record<Tissue, { isovalue: number; near: readonly [number, number] }> = {
  skin: { isovalue: -300, near: [-450, -150] },
  bone: { isovalue: 250, near: [150, 1000] },
};

/**
 * The isovalues to choose from: those that the store suggests, best first, and in Hounsfield units also those of
 * tissues that no suggestion shows.
 */
export function isovalueChoices(info: StoreInfo): IsovalueChoice[] {
  const suggestions = (info.metadata.suggested_isovalues ?? []).slice(0, mostChoices);
  if (info.metadata.units?.trim() === "HU") return withTissues(info, suggestions);
  const { mean, deviation } = densityStatistics(info) ?? {};
  if (mean === undefined || !deviation) return suggestions.map((isovalue) => ({ isovalue }));
  return suggestions.map((isovalue) => ({ isovalue, deviations: (isovalue - mean) / deviation }));
}

function withTissues(info: StoreInfo, suggestions: readonly number[]): IsovalueChoice[] {
  const named = suggestions.map((isovalue): IsovalueChoice => {
    const tissue = tissueNames.find((name) => isNear(isovalue, name));
    return tissue ? { isovalue, tissue } : { isovalue };
  });
  const added = tissueNames
    .filter((name) => !suggestions.some((isovalue) => isNear(isovalue, name)))
    .map((tissue) => ({ isovalue: tissues[tissue].isovalue, tissue }))
    .filter(({ isovalue }) => (activeCellsAt(info, isovalue) ?? 0) > 0);
  return [...named.slice(0, mostChoices - added.length), ...added];
}

const tissueNames = Object.keys(tissues) as Tissue[];

function isNear(isovalue: number, tissue: Tissue): boolean {
  const [low, high] = tissues[tissue].near;
  return isovalue >= low && isovalue <= high;
}

/** Of the values of an electron density map; undefined for other volumes. */
function densityStatistics({
  metadata: { source, histogram },
}: StoreInfo): { mean: number; deviation: number } | undefined {
  return source?.format === "MRC" && histogram ? statisticsOf(histogram) : undefined;
}

/** Mean and standard deviation of the middles of the bins. */
function statisticsOf({
  low,
  high,
  counts,
}: Bins): { mean: number; deviation: number } | undefined {
  const width = (high - low) / counts.length;
  const middle = (bin: number) => low + (bin + 0.5) * width;
  const total = counts.reduce((sum, count) => sum + count, 0);
  if (!(total > 0)) return undefined;
  const meanOf = (value: (bin: number) => number) =>
    counts.reduce((sum, count, bin) => sum + count * value(bin), 0) / total;
  const mean = meanOf(middle);
  return { mean, deviation: Math.sqrt(meanOf((bin) => (middle(bin) - mean) ** 2)) };
}
