/** The least weight of a layer, such as one outside of the picture, relative to the largest weight. */
const leastShare = 0.05;

/** The numbers that determine the share of one layer in the sample budget. */
export interface SampleNeed {
  /** Samples that stay resident in any case: its coarse levels. */
  pinned: number;
  /** The share of the picture that its volume covers. */
  coverage: number;
  /** The number of its surfaces. */
  surfaces: number;
}

/**
 * Divides a sample budget among the layers that are shown. A surface needs samples in proportion to its
 * size on the screen. So each layer keeps its coarse levels, and the rest is divided in proportion to
 * coverage × surfaces. A single layer gets all.
 */
export function shareSamples(budget: number, needs: readonly SampleNeed[]): number[] {
  if (needs.length <= 1) return needs.map(() => budget);
  const sizes = needs.map(({ coverage, surfaces }) => coverage * surfaces);
  const largest = Math.max(...sizes);
  const weights = sizes.map((size) => (largest > 0 ? Math.max(size, leastShare * largest) : 1));
  const sum = weights.reduce((all, weight) => all + weight, 0);
  const pinned = needs.reduce((all, need) => all + need.pinned, 0);
  const rest = Math.max(0, budget - pinned);
  return needs.map((need, i) => Math.floor(need.pinned + (rest * (weights[i] ?? 0)) / sum));
}
