/** A part of a file: its first and last byte. */
export interface Part {
  first: number;
  last: number;
}

/** "bytes=5-9" and "bytes 5-9/100" as a part; undefined: something else. */
export function partIn(text: string | null): Part | undefined {
  const [, first, last] = /^bytes[= ](\d+)-(\d+)(?:\/|$)/.exec(text ?? "") ?? [];
  return first === undefined ? undefined : { first: Number(first), last: Number(last) };
}

/** Stored parts that together contain a part, in order; undefined if some byte is in none of them. */
export function covering<P extends Part>(wanted: Part, stored: readonly P[]): P[] | undefined {
  const chosen: P[] = [];
  let next = wanted.first;
  while (next <= wanted.last) {
    // Of the parts that contain the next byte, the one that extends furthest.
    const [best] = stored
      .filter(({ first, last }) => first <= next && last >= next)
      .sort((a, b) => b.last - a.last);
    if (!best) return undefined;
    chosen.push(best);
    next = best.last + 1;
  }
  return chosen;
}
