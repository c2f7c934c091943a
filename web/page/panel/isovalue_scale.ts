import { roundBelow } from "../../core/round_below.ts";
import type { StoreInfo } from "../../core/types.ts";

/** The isovalues that the slider of a volume can have. */
export interface IsovalueScale {
  low: number;
  high: number;
  /**
   * The step: ½ for whole numbers with a range of up to 1000, otherwise a round number from 1/5000 to
   * 1/2000 of the range.
   */
  step: number;
}

export function isovalueScale(
  range: readonly [number, number],
  quantizationStep: number,
): IsovalueScale {
  const [low, high] = range;
  const span = high - low;
  if (!(span > 0)) return { low, high: low + 1, step: 1 };
  const isWhole = quantizationStep === 1 && Number.isInteger(low);
  const step = isWhole && span <= 1000 ? 0.5 : roundBelow(span / 2000);
  return { low, high, step };
}

/** The nearest multiple of the step within the range. */
export function roundToScale(value: number, scale: IsovalueScale): number {
  const inside = Math.min(scale.high, Math.max(scale.low, value));
  const onGrid = Math.round(inside / scale.step) * scale.step;
  return Math.min(scale.high, Math.max(scale.low, Number(onGrid.toPrecision(10))));
}

/** The ends of a slider: multiples of the step, since browsers count its steps from the low end. */
export function sliderEnds({ low, high, step }: IsovalueScale): [number, number] {
  const multiple = (count: number) => Number((count * step).toPrecision(10));
  return [multiple(Math.floor(low / step)), multiple(Math.ceil(high / step))];
}

/** Position of a value between low (0) and high (1). */
export function fraction(value: number, scale: IsovalueScale): number {
  return (value - scale.low) / (scale.high - scale.low);
}

/**
 * The first isovalue of a volume: its first suggestion, or else the value at 30 % of its range.
 */
export function firstIsovalue({ range, mapping, metadata }: StoreInfo): number {
  const scale = isovalueScale(range, mapping.scale);
  const { low, high } = scale;
  return metadata.suggested_isovalues?.[0] ?? roundToScale(low + 0.3 * (high - low), scale);
}
