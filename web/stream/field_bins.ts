import type { Bins, FieldInfo } from "../core/types.ts";

const bins = 256;

/** How often the values of a field occur at the corners of the cells of chunks, in equal parts of its range. */
export class FieldBins {
  readonly #field: FieldInfo;
  readonly #counts = new Map<number, Uint32Array>();
  /** The quantized values of each chunk, if they are categories. */
  readonly #values = new Map<number, ReadonlySet<number>>();

  constructor(field: FieldInfo) {
    this.#field = field;
  }

  /** `values`: PackedField of each sample of a chunk. isCategory: they are labels. */
  add(chunk: number, values: Uint32Array, isCategory = false): void {
    if (isCategory) this.#values.set(chunk, distinct(values));
    const counts = new Uint32Array(bins);
    const { quantizedRange, mapping } = this.#field;
    const [low, high] = quantizedRange;
    const perValue = bins / Math.max(1, high - low);
    const missing = mapping.hasMissing ? 65_535 : -1;
    for (const word of values) {
      for (const value of [word & 0xffff, word >>> 16]) {
        const bin = Math.min(bins - 1, Math.floor((value - low) * perValue));
        if (value !== missing) counts[bin] = (counts[bin] ?? 0) + 1;
      }
    }
    this.#counts.set(chunk, counts);
  }

  remove(chunk: number): void {
    this.#counts.delete(chunk);
    this.#values.delete(chunk);
  }

  /** The labels that occur in these chunks. */
  labels(chunks: readonly number[]): Set<number> {
    const { offset, scale, hasMissing } = this.#field.mapping;
    const found = new Set<number>();
    for (const chunk of chunks) {
      for (const value of this.#values.get(chunk) ?? []) found.add(value);
    }
    if (hasMissing) found.delete(65_535);
    return new Set([...found].map((value) => Math.round(offset + scale * value)));
  }

  /** The counts of all these chunks together, from the lowest to the highest value of the field. */
  histogram(chunks: readonly number[]): Bins {
    const counts: number[] = Array(bins).fill(0);
    for (const chunk of chunks) {
      this.#counts.get(chunk)?.forEach((count, bin) => {
        counts[bin] = (counts[bin] ?? 0) + count;
      });
    }
    const [low, high] = this.#field.range;
    return { low, high, counts };
  }

  /**
   * A range around the values of these chunks without the lowest and highest `share` of them. Undefined if they
   * have no values.
   */
  percentiles(chunks: readonly number[], share: number): [number, number] | undefined {
    const { low, high, counts: sums } = this.histogram(chunks);
    const all = sums.reduce((sum, count) => sum + count, 0);
    if (all === 0) return undefined;
    const least = share * all;
    const binAt = (order: readonly number[]): number => {
      let sum = 0;
      for (const bin of order) {
        sum += sums[bin] ?? 0;
        if (sum > least) return bin;
      }
      return 0;
    };
    const ascending = Array.from(sums.keys());
    const [first, last] = [binAt(ascending), binAt([...ascending].reverse())];
    const width = (high - low) / bins;
    return [low + first * width, low + (last + 1) * width];
  }
}

/** The distinct quantized values of PackedFields. */
function distinct(values: Uint32Array): Set<number> {
  const found = new Set<number>();
  let last = -1;
  for (const word of values) {
    if (word === last) continue; // neighbours are often equal
    last = word;
    found.add(word & 0xffff);
    found.add(word >>> 16);
  }
  return found;
}
