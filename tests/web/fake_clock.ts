/** A clock that tests advance. It has animation frames, which Node lacks. */
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

/**
 * In each test of the present file, timers run in real time, so that connections work; `passTime`
 * makes time jump.
 */
export function clockThatJumps(): void {
  beforeEach(() => {
    vi.useFakeTimers({
      toFake: ["setTimeout", "clearTimeout", "setInterval", "clearInterval"],
      shouldAdvanceTime: true,
      advanceTimeDelta: 5,
    });
  });
  afterEach(() => {
    vi.useRealTimers();
  });
}

/**
 * Runs all timers of this time at once. Resolves when the requests that they make have arrived at
 * the host to which `ask` makes a request.
 */
export async function passTime(milliseconds: number, ask: () => Promise<Response>): Promise<void> {
  await vi.advanceTimersByTimeAsync(milliseconds);
  for (let i = 0; i < 3; ++i) await (await ask()).arrayBuffer();
}
