/**
 * Moves an isovalue through its range and back, again and again, in animation frames. The first value
 * is the present one.
 */
export class IsovalueSweep {
  readonly #set: (value: number) => void;
  #handle = 0;

  constructor(set: (value: number) => void) {
    this.#set = set;
  }

  get isRunning(): boolean {
    return this.#handle !== 0;
  }

  /** seconds: duration from low to high. */
  start(from: number, low: number, high: number, seconds: number): void {
    this.stop();
    let begin: number | undefined;
    const step = (now: number): void => {
      begin ??= now;
      const share = (from - low) / (high - low) + (now - begin) / (1000 * seconds);
      this.#handle = requestAnimationFrame(step);
      this.#set(low + backAndForth(share) * (high - low));
    };
    this.#handle = requestAnimationFrame(step);
  }

  stop(): void {
    cancelAnimationFrame(this.#handle);
    this.#handle = 0;
  }
}

/** 0 → 0, 1 → 1, 2 → 0, and so on. */
export function backAndForth(share: number): number {
  const rest = ((share % 2) + 2) % 2;
  return rest <= 1 ? rest : 2 - rest;
}
