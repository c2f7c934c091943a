import type { StoreInfo } from "../stream/index.ts";

/** The isovalues that a slider over a volume can take. */
export interface IsovalueScale {
  low: number;
  high: number;
  /** A round number: ½ for 8-bit volumes, about 1/2000 of the range otherwise. */
  step: number;
}

/** 0.0037 → 0.002: the largest of 1, 2, 5 · 10ⁿ that is not larger. */
export function roundStep(step: number): number {
  const power = 10 ** Math.floor(Math.log10(step));
  const digit = step / power;
  const round = digit >= 5 ? 5 : digit >= 2 ? 2 : 1;
  // Through its decimal form, so that 0.1 is not 0.1000…01.
  return Number((round * power).toPrecision(12));
}

export function isovalueScale(
  range: readonly [number, number],
  quantizationStep: number,
): IsovalueScale {
  const [low, high] = range;
  const span = high - low;
  if (!(span > 0)) return { low, high: low + 1, step: 1 };
  const isWhole = quantizationStep === 1 && Number.isInteger(low);
  const step = isWhole && span <= 1000 ? 0.5 : roundStep(span / 2000);
  return { low, high, step };
}

/** The nearest isovalue on the scale's grid (multiples of the step), within its range. */
export function snapped(value: number, scale: IsovalueScale): number {
  const inside = Math.min(scale.high, Math.max(scale.low, value));
  const onGrid = Math.round(inside / scale.step) * scale.step;
  return Math.min(scale.high, Math.max(scale.low, Number(onGrid.toPrecision(10))));
}

/** Where a value lies between low (0) and high (1). */
export function fraction(value: number, scale: IsovalueScale): number {
  return (value - scale.low) / (scale.high - scale.low);
}

/** What a volume is first seen at: what it suggests, or else above the most frequent values. */
export function firstIsovalue({ range, mapping, metadata }: StoreInfo): number {
  const scale = isovalueScale(range, mapping.scale);
  const { low, high } = scale;
  return metadata.suggested_isovalues?.[0] ?? snapped(low + 0.3 * (high - low), scale);
}
