/** The growth of figures with the number of voxels: exponents of power laws, and their names. */

/** One size of a volume: its number of voxels, and a figure measured for it. */
export interface Point {
  voxels: number;
  figure: number;
}

/** The exponent e of figure ∝ voxels^e by least squares of the logarithms. */
export function exponentOf(points: readonly Point[]): number {
  if (points.length < 2) throw new Error(`expected at least 2 sizes, found ${points.length}`);
  const logs = points.map(({ voxels, figure }) => {
    if (!(voxels > 0 && figure > 0)) throw new Error(`expected figures above 0, found ${figure}`);
    return [Math.log(voxels), Math.log(figure)] as const;
  });
  const mean = (axis: 0 | 1) => logs.reduce((sum, log) => sum + log[axis], 0) / logs.length;
  const [x, y] = [mean(0), mean(1)];
  const across = logs.reduce((sum, log) => sum + (log[0] - x) ** 2, 0);
  if (across === 0) throw new Error("expected volumes of different sizes, found one size");
  return logs.reduce((sum, log) => sum + (log[0] - x) * (log[1] - y), 0) / across;
}

/** Exponents that differ by less than this count as equal, because times vary and there are few sizes. */
const tolerance = 0.15;

/**
 * The order of growth. A figure that grows with the voxels has exponent 1; one that depends on the screen
 * has 0. The exponent of the surface is that of the active cells: 2/3 if it is smooth, more for a fractal.
 */
export function orderOf(exponent: number, surface: number): string {
  const orders: [string, number][] = [
    ["O(screen)", 0],
    ["O(surface)", surface],
    ["O(voxels)", 1],
  ];
  const distance = ([, of]: [string, number]) => Math.abs(of - exponent);
  const [nearest, next] = orders.sort((a, b) => distance(a) - distance(b));
  if (!nearest || !next) return "";
  if (distance(nearest) <= tolerance) return nearest[0];
  const [low, high] = nearest[1] < next[1] ? [nearest, next] : [next, nearest];
  if (low[1] < exponent && exponent < high[1]) return `between ${low[0]} and ${high[0]}`;
  return exponent < low[1] ? `less than ${low[0]}` : `more than ${high[0]}`;
}
