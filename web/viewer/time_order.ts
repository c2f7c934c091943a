/** What follows the last step: the first one, the steps backwards, or nothing. */
export type PlayMode = "loop" | "swing" | "once";

export const playModes: readonly PlayMode[] = ["loop", "swing", "once"];

/** A step, and the direction to the next step: 1 or −1. */
export interface PlayPosition {
  step: number;
  direction: 1 | -1;
}

/** The position that follows when `count` steps are played; null at the end. */
export function nextPosition(
  { step, direction }: PlayPosition,
  count: number,
  mode: PlayMode,
): PlayPosition | null {
  if (count < 2) return null;
  const next = step + direction;
  if (next >= 0 && next < count) return { step: next, direction };
  if (mode === "once") return null;
  if (mode === "loop") return { step: direction > 0 ? 0 : count - 1, direction };
  const turned = direction > 0 ? -1 : 1;
  return { step: step + turned, direction: turned };
}

/**
 * All other steps in the order in which they will probably be shown: those that play next, each once, and
 * then the rest, the nearest first.
 */
export function stepsAhead(position: PlayPosition, count: number, mode: PlayMode): number[] {
  const order = new Set<number>([position.step]);
  let next: PlayPosition | null = position;
  // A swing passes every step within twice their number.
  for (let i = 0; i < 2 * count && next && order.size < count; ++i) {
    next = nextPosition(next, count, mode);
    if (next) order.add(next.step);
  }
  for (let distance = 1; distance < count; ++distance) {
    for (const step of [
      position.step + position.direction * distance,
      position.step - position.direction * distance,
    ]) {
      if (step >= 0 && step < count) order.add(step);
    }
  }
  return [...order].slice(1);
}

/** The step whose value is nearest to `value`. `values` increase. */
export function nearestStep(values: readonly number[], value: number): number {
  let nearest = 0;
  values.forEach((each, step) => {
    if (Math.abs(each - value) < Math.abs((values[nearest] ?? 0) - value)) nearest = step;
  });
  return nearest;
}
