import type { Triple } from "../core/types.ts";

export function dot(a: Triple, b: Triple): number {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

export function cross([a1, a2, a3]: Triple, [b1, b2, b3]: Triple): Triple {
  return [a2 * b3 - a3 * b2, a3 * b1 - a1 * b3, a1 * b2 - a2 * b1];
}

export function plus(a: Triple, b: Triple): Triple {
  return [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
}

export function times(v: Triple, factor: number): Triple {
  return [v[0] * factor, v[1] * factor, v[2] * factor];
}
