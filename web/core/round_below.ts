/** The largest number of the form 1, 2, 5 · 10ⁿ that is not larger: 0.0037 → 0.002. */
export function roundBelow(value: number): number {
  const power = 10 ** Math.floor(Math.log10(value));
  const digit = value / power;
  // A quotient such as 4.999… is treated as 5.
  const round = digit > 5 - 1e-9 ? 5 : digit > 2 - 1e-9 ? 2 : 1;
  // Uses the decimal form, which gives 0.1 and not 0.1000…01.
  return Number((round * power).toPrecision(12));
}
