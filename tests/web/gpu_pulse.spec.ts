import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { GpuPulse } from "../../web/viewer/gpu_timer.ts";

beforeEach(() => {
  vi.useFakeTimers({ toFake: ["performance"] });
});
afterEach(() => {
  vi.useRealTimers();
});

/** Of WebGL, what a pulse uses: each fence is signalled so many milliseconds after it was sent. */
function fences(latency: number): WebGL2RenderingContext {
  const sent = new Map<object, number>();
  const gl = {
    UNSIGNALED: 0,
    SIGNALED: 1,
    fenceSync: () => {
      const fence = {};
      sent.set(fence, performance.now());
      return fence;
    },
    getSyncParameter: (fence: object) =>
      performance.now() - (sent.get(fence) ?? 0) >= latency ? 1 : 0,
    deleteSync: () => {},
    flush: () => {},
  };
  return gl as unknown as WebGL2RenderingContext;
}

/** Milliseconds until it beats, asked every 8 ms. */
function untilBeat(pulse: GpuPulse): number {
  const startedAt = performance.now();
  for (let turn = 0; turn < 1000; ++turn) {
    if (pulse.beats()) return performance.now() - startedAt;
    vi.advanceTimersByTime(8);
  }
  return Number.POSITIVE_INFINITY;
}

test("a GPU that answers at once beats at the next look", () => {
  expect(untilBeat(new GpuPulse(fences(1)))).toBe(8);
});

test("a GPU that never answers at once is not waited for without end", () => {
  const pulse = new GpuPulse(fences(20));
  const first = untilBeat(pulse);
  expect(first).toBeGreaterThan(100);
  expect(first).toBeLessThan(1000);
  // And each time anew: nothing is taken for idle because it was busy before.
  expect(untilBeat(pulse)).toBeGreaterThan(100);
});
