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

/**
 * Timers of each test of the present file run as real ones do, so that connections work, and passTime
 * lets them pass at once.
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
 * What timers would do within this time has been done afterwards, and the requests that they make
 * have arrived where `ask` makes a request.
 */
export async function passTime(milliseconds: number, ask: () => Promise<Response>): Promise<void> {
  await vi.advanceTimersByTimeAsync(milliseconds);
  for (let i = 0; i < 3; ++i) await (await ask()).arrayBuffer();
}
