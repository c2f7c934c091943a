/** Tables of docs/scale.md: how figures grow with the number of voxels. */
import { exponentOf, orderOf, type Point } from "../growth/exponents.ts";
import { readResults } from "../harness/table.ts";
import { amount, markdown } from "./markdown.ts";

/** A figure of the benchmark `growth`. */
export interface Measure {
  name: string;
  unit: string;
}

/** Volumes of one kind, the smallest first. */
export class Series {
  readonly #rows;
  /** Their sizes, as the benchmark names them: "64³". */
  readonly sizes: string[];

  constructor(kind: string) {
    const prefix = `${kind} `;
    this.#rows = readResults("growth")
      .filter((row) => row.case.startsWith(prefix))
      .map((row) => ({ ...row, size: row.case.slice(prefix.length) }));
    const voxels = this.#rows.filter(({ measure }) => measure === "voxels");
    if (voxels.length < 2) throw new Error(`growth.csv: expected at least two sizes of ${kind}`);
    this.sizes = voxels.sort((a, b) => a.median - b.median).map(({ size }) => size);
  }

  #figure(size: string | undefined, { name, unit }: Measure): number {
    const row = this.#rows.find((r) => r.size === size && r.measure === name && r.unit === unit);
    if (!row) throw new Error(`growth.csv: expected a row "${name}" in "${unit}" of "${size}"`);
    // Use the minimum of processor times: other programs can only increase them, by emptying the
    // caches.
    return name.endsWith("processor time") ? row.min : row.median;
  }

  points(measure: Measure): Point[] {
    return this.sizes.map((size) => ({
      voxels: 1e6 * this.#figure(size, { name: "voxels", unit: "million" }),
      figure: this.#figure(size, measure),
    }));
  }

  /**
   * The figure of the second largest size and that of the largest, each with its number of voxels.
   */
  lastTwo(measure: Measure): [Point, Point] {
    const [before, last] = this.points(measure).slice(-2);
    if (!before || !last) throw new Error("growth.csv: expected at least two sizes");
    return [before, last];
  }

  /** The figure of the largest volume. */
  last(measure: Measure): number {
    return this.#figure(this.sizes.at(-1), measure);
  }

  /**
   * The exponent from the second largest size to the largest. There, constant parts (the header,
   * the program's memory) have the least influence.
   */
  lastExponent(measure: Measure): number {
    return exponentOf(this.lastTwo(measure));
  }
}

export const measures = {
  build: { name: "build, processor time", unit: "s" },
  memory: { name: "build, peak memory", unit: "MB" },
  store: { name: "store", unit: "MB" },
  pages: { name: "directory pages", unit: "KB" },
  active: { name: "active cells", unit: "million" },
  cells: { name: "cells of the isovalue's chunks", unit: "million" },
  bytes: { name: "isovalue, level 0", unit: "KB" },
  chunks: { name: "isovalue, level 0", unit: "chunks" },
  extraction: { name: "extraction, processor time", unit: "ms" },
  first: { name: "until the first surface", unit: "KB" },
  small: { name: "until complete, 128 × 96", unit: "KB" },
  large: { name: "until complete, 1024 × 768", unit: "KB" },
} satisfies Record<string, Measure>;

/** The growth of all measures of a kind of volumes, with exponents and orders. */
export function growthTable(kind: string): string {
  const series = new Series(kind);
  const surface = series.lastExponent(measures.active);
  const heading = [kind, ...series.sizes, "exponent", "of the last step", "order"];
  const line = (measure: Measure) => {
    const points = series.points(measure);
    const last = series.lastExponent(measure);
    return [
      `${measure.name}, ${measure.unit}`,
      ...points.map(({ figure }) => amount(figure)),
      exponentOf(points).toFixed(2),
      last.toFixed(2),
      measure === measures.active ? "the surface itself" : orderOf(last, surface),
    ];
  };
  return markdown([heading, heading.map(() => "---"), ...Object.values(measures).map(line)]);
}
