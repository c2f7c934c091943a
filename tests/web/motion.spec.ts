// Prediction of the isovalue's motion. Two changes in quick succession are not yet a motion.
import { afterEach, beforeEach, expect, it, vi } from "vitest";
import { Motion } from "../../web/stream/motion.ts";

beforeEach(() => {
  vi.useFakeTimers();
});
afterEach(() => {
  vi.useRealTimers();
});

const range = 255;

/** Shows these isovalues one after the other, at an interval in ms. */
function moved(isovalues: readonly number[], apart: number): Motion {
  const motion = new Motion(() => {});
  for (const isovalue of isovalues) {
    vi.advanceTimersByTime(apart);
    motion.changed({
      viewProjection: new Float64Array(16),
      viewport: { width: 800, height: 600 },
      isovalues: [isovalue],
      moving: true,
    });
  }
  return motion;
}

it("predicts the isovalue of a moving slider", () => {
  const motion = moved([100, 100.5, 101, 101.5, 102, 102.5, 103, 103.5, 104], 20);
  expect(motion.isovalueMoves).toBe(true);
  // 25 a second, for 0.4 s.
  expect(motion.isovaluesAhead(range, false)?.[0]).toBeCloseTo(114);
  expect(motion.isovaluesAhead(range, false)).toBeUndefined(); // not again at once
  motion.close();
});

it("does not take two quick key presses for a continuing movement", () => {
  const motion = moved([100, 100.5, 101], 20);
  expect(motion.isovalueMoves).toBe(true);
  expect(motion.isovaluesAhead(range, false)).toBeUndefined();
  motion.close();
});

it("predicts nothing if the slider goes back and forth, or too fast", () => {
  const trembling = moved([100, 101, 100, 101, 100, 101, 100, 101, 100], 20);
  expect(trembling.isovaluesAhead(range, false)).toBeUndefined();
  trembling.close();
  const fast = moved([20, 40, 60, 80, 100, 120, 140, 160], 20);
  expect(fast.isovaluesAhead(range, false)).toBeUndefined();
  fast.close();
});

it("predicts only slow movements if fine levels are resident for every isovalue", () => {
  const steps = (by: number) => Array.from({ length: 9 }, (_, i) => 100 + i * by);
  const whole = moved(steps(0.5), 20); // 25 a second: the range in 10 s
  expect(whole.isovaluesAhead(range, true)).toBeUndefined();
  whole.close();
  const slow = moved(steps(0.125), 20);
  expect(slow.isovaluesAhead(range, true)?.[0]).toBeCloseTo(103.5);
  slow.close();
});

it("ends when nothing has changed for a while", () => {
  const rested = vi.fn();
  const motion = new Motion(rested);
  const view = { viewProjection: new Float64Array(16), viewport: { width: 8, height: 6 } };
  motion.changed({ ...view, isovalues: [1], moving: true });
  vi.advanceTimersByTime(1000);
  motion.changed({ ...view, isovalues: [2], moving: true });
  expect(motion.isovalueMoves).toBe(false); // a single change
  vi.advanceTimersByTime(20);
  motion.changed({ ...view, isovalues: [3], moving: true });
  expect(motion.isovalueMoves).toBe(true);
  vi.advanceTimersByTime(1000);
  expect(rested).toHaveBeenCalledOnce();
  expect(motion.isovalueMoves).toBe(false);
  motion.close();
});
