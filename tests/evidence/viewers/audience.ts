/** The arrivals of viewers: their times and volumes. */
import { Chance } from "../../support/chance.ts";
import type { PlannedVisit, RecordedVisit } from "./requests.ts";

export interface AudienceOptions {
  viewers: number;
  /** The average time within which all viewers come. */
  minutes: number;
  /** Recorded visits of each volume, the most popular volume first. */
  visits: readonly (readonly RecordedVisit[])[];
  /** The share of the volume of rank r is in proportion to r^−exponent (Zipf). */
  exponent: number;
  seed: number;
}

const sum = (values: readonly number[]) => values.reduce((all, value) => all + value, 0);

/** Shares of ranks 1 … count by Zipf's law. Their sum is 1. */
export function zipf(count: number, exponent: number): number[] {
  const weights = Array.from({ length: count }, (_, i) => (i + 1) ** -exponent);
  const total = sum(weights);
  return weights.map((weight) => weight / total);
}

/**
 * Arrivals of a Poisson process, in their order: the times between them are distributed exponentially.
 * Each viewer repeats one recorded visit, chosen at random among those of the volume.
 */
export function audience(options: AudienceOptions): PlannedVisit[] {
  const { viewers, minutes, visits, exponent, seed } = options;
  if (visits.length === 0 || visits.some((list) => list.length === 0)) {
    throw new Error("expected recorded visits of each volume, found none");
  }
  const chance = new Chance(seed);
  const shares = zipf(visits.length, exponent);
  // Because of rounding, the sum of shares may be less than 1. The remainder belongs to the last
  // rank.
  const ends = shares.slice(0, -1).map((_, i) => sum(shares.slice(0, i + 1)));
  const meanGap = (60_000 * minutes) / viewers;
  let at = 0;
  return Array.from({ length: viewers }, () => {
    at -= meanGap * Math.log(1 - chance.next());
    const drawn = chance.next();
    const rank = ends.findIndex((end) => drawn < end);
    return { at, visit: chance.of(visits.at(rank) as readonly RecordedVisit[]) };
  });
}
