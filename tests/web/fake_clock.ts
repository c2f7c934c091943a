/** A clock that tests advance, with animation frames, which Node has not. */
import { afterEach, beforeEach, vi } from "vitest";

/** Timers and frames of each test of the present file or group wait for vi.advanceTimersByTime. */
export function fakeClock(): void {
  beforeEach(() => {
    vi.useFakeTimers();
    vi.stubGlobal("window", globalThis);
    vi.stubGlobal("requestAnimationFrame", (frame: (now: number) => void) =>
      Number(setTimeout(() => frame(performance.now()), 16)),
    );
    vi.stubGlobal("cancelAnimationFrame", (handle: number) => clearTimeout(handle));
  });
  afterEach(() => {
    vi.unstubAllGlobals();
    vi.useRealTimers();
  });
}
