import type { LevelCost } from "../stream/level_cost.ts";

/** The detail in which steps play, as the size up to which cells are not refined (device pixels). */
export const playCellPixels: readonly number[] = [1, 2, 4, 8, 16, 32, 64];

/**
 * The expected bandwidth, relative to the measured one. `first`: before playing, requests are made for one step at
 * a time, and mostly wait for the server. Requests for several steps at a time hide this wait, so more is expected.
 * `late`: after steps have come late, requests for several steps have been measured.
 */
const expectedShare = { first: 2, late: 0.9 };
/** While finer cells replace coarser ones, a step takes this many times its final number of samples. */
const whileReplaced = 1.4;
/** At least this number of steps is kept ahead. If there is too little memory, they are coarser. */
const fewestAhead = 2;

/** The bytes of a cell, as long as they are not known for any level. */
const typicalCellBytes = 2.5;

/** The costs of the levels finer than `coarsest`. Unknown costs are estimated from the next known level. */
export function completeCosts(
  known: readonly LevelCost[],
  coarsest: number,
  activeCells: number | undefined,
): LevelCost[] {
  const costs: LevelCost[] = [];
  let next = known.find(({ level }) => level === coarsest);
  for (let level = coarsest - 1; level >= 0; --level) {
    let cost = known.find((each) => each.level === level);
    if (!cost && activeCells !== undefined) {
      // A surface has a quarter of the cells at the next coarser level.
      const cells = activeCells / 4 ** level;
      const bytesPerCell = next && next.cells > 0 ? next.bytes / next.cells : typicalCellBytes;
      cost = { level, cells, bytes: cells * bytesPerCell };
    }
    cost ??= next && { level, cells: 4 * next.cells, bytes: 4 * next.bytes };
    if (cost) costs.unshift(cost);
    next = cost;
  }
  return costs;
}

/**
 * The cell size at which steps play without a stop: the smallest one whose bytes arrive in the time that a
 * step is shown.
 *
 * bytesAt: the bytes of a step that are to be fetched. bytesPerSecond: measured; undefined: nothing is known,
 * and nothing is left out. isLate: steps were shown before they were as fine as they should be.
 */
export function cellPixelsThatPlay(
  bytesAt: (pixels: number) => number,
  stepsPerSecond: number,
  bytesPerSecond: number | undefined,
  isLate = false,
): number {
  if (bytesPerSecond === undefined) return 1;
  const share = isLate ? expectedShare.late : expectedShare.first;
  const affordable = (share * bytesPerSecond) / stepsPerSecond;
  return (
    playCellPixels.find((pixels) => bytesAt(pixels) <= affordable) ?? playCellPixels.at(-1) ?? 1
  );
}

/** The number of other steps that a budget of samples holds, if each needs `samples`. */
export function stepsThatFit(budget: number, samples: number, others: number): number {
  const fitting = samples > 0 ? Math.floor(budget / (whileReplaced * samples)) : others;
  return Math.min(others, Math.max(fewestAhead, fitting));
}

/** The steps to fetch in advance. */
export interface AheadPlan {
  /** Steps whose coarse levels are resident or being fetched. They include the steps of `refined`. */
  kept: number[];
  /** Steps that are refined now. */
  refined: number[];
}

export interface AheadOptions {
  /** The other steps, the next one first: `stepsAhead`. */
  ahead: readonly number[];
  /** The largest number of steps in `kept`: see stepsThatFit. */
  most: number;
  /** The largest number of bytes to fetch for steps that are not shown yet, and the bytes of one step. */
  byteBudget: number;
  stepBytes: number;
  /** Whether a step has the resolution that the view needs. */
  isReady(step: number): boolean;
  isPlaying: boolean;
}

/** The number of steps that are fetched at the same time, so that none waits for another's round trip. */
const refinedTogether = 3;
/** The number of steps that are fetched ahead at rest, since the next key press may show them. */
const aheadAtRest = 2;

/** Chooses the steps to fetch. Steps that are ready stay as long as they fit. */
export function planAhead(options: AheadOptions): AheadPlan {
  const { ahead, most, byteBudget, stepBytes, isReady, isPlaying } = options;
  const affordable = stepBytes > 0 ? Math.floor(byteBudget / stepBytes) : ahead.length;
  const reach = isPlaying ? Math.max(fewestAhead, affordable) : aheadAtRest;
  const kept: number[] = [];
  const refined: number[] = [];
  ahead.slice(0, most).forEach((step, i) => {
    const isFine = isReady(step);
    if (!isFine && i >= reach) return;
    kept.push(step);
    if (!isFine && refined.length < (isPlaying ? refinedTogether : 1)) refined.push(step);
  });
  return { kept, refined };
}
