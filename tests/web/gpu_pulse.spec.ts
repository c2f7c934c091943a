// When GpuPulse reports that the GPU responds at once; the test decides when fences are signalled.
import { afterEach, beforeEach, expect, it, vi } from "vitest";
import { GpuPulse } from "../../web/viewer/gpu_timer.ts";

/** A context whose fences are signalled when `passed` is set. */
function context(): { gl: WebGL2RenderingContext; passed: boolean; alive: number } {
  const state = {
    passed: false,
    alive: 0,
    gl: {
      UNSIGNALED: 0x9118,
      getSyncParameter: () => (state.passed ? 0x9119 : 0x9118),
      fenceSync: () => {
        ++state.alive;
        return {};
      },
      deleteSync: (fence: unknown) => {
        if (fence) --state.alive;
      },
      flush: () => {},
    } as unknown as WebGL2RenderingContext,
  };
  return state;
}

beforeEach(() => {
  vi.useFakeTimers();
});
afterEach(() => {
  vi.useRealTimers();
});

it("beats if the commands sent at one call are done at the next", () => {
  const gpu = context();
  const pulse = new GpuPulse(gpu.gl);
  expect(pulse.beats()).toBe(false); // nothing was sent yet
  gpu.passed = true;
  vi.advanceTimersByTime(8);
  expect(pulse.beats()).toBe(true);
  expect(gpu.alive).toBe(1);
});

it("does not beat for a late fence, but for the next one", () => {
  const gpu = context();
  const pulse = new GpuPulse(gpu.gl);
  pulse.beats();
  vi.advanceTimersByTime(8);
  expect(pulse.beats()).toBe(false);
  gpu.passed = true;
  vi.advanceTimersByTime(8);
  expect(pulse.beats()).toBe(false);
  vi.advanceTimersByTime(8);
  expect(pulse.beats()).toBe(true);
  expect(gpu.alive).toBe(1);
});

it("ignores a fence that was sent long ago", () => {
  const gpu = context();
  const pulse = new GpuPulse(gpu.gl);
  pulse.beats();
  gpu.passed = true;
  vi.advanceTimersByTime(1000);
  expect(pulse.beats()).toBe(false);
  vi.advanceTimersByTime(8);
  expect(pulse.beats()).toBe(true);
});

it("limits the wait if the GPU never responds at once", () => {
  const gpu = context();
  const pulse = new GpuPulse(gpu.gl);
  const callsUntilBeat = (): number => {
    for (let call = 1; call <= 1000; ++call) {
      // The fence of the second last call is signalled, but never that of the last call.
      gpu.passed = call % 2 === 0;
      if (pulse.beats()) return call;
      vi.advanceTimersByTime(8);
    }
    return Number.POSITIVE_INFINITY;
  };
  pulse.beats();
  expect(callsUntilBeat()).toBeLessThan(100);
  // After a busy period, the next check does not report an idle GPU at once.
  expect(callsUntilBeat()).toBeGreaterThan(10);
  expect(gpu.alive).toBe(1);
});
