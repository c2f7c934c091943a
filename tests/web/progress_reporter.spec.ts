/** The changes of progress that are reported at once. */
import { afterEach, expect, test, vi } from "vitest";
import { ProgressReporter } from "../../web/stream/progress_reporter.ts";
import type { Progress } from "../../web/stream/types.ts";

afterEach(() => {
  vi.useRealTimers();
});

test("reports changed numbers later, but the last chunk and new missing chunks at once", () => {
  vi.useFakeTimers();
  let current = { state: "refining", chunksToGo: 5, bytesFetched: 0 } as Progress;
  const reported: number[] = [];
  const reporter = new ProgressReporter(
    () => current,
    ({ chunksToGo }) => reported.push(chunksToGo),
    () => {},
  );
  const update = (chunksToGo: number, bytesFetched: number): void => {
    current = { ...current, chunksToGo, bytesFetched };
    reporter.update();
  };
  update(5, 0);
  update(4, 1000);
  update(3, 2000);
  expect(reported).toEqual([5]);
  // The picture of a view is drawn when its last chunk has arrived.
  update(0, 5000);
  expect(reported).toEqual([5, 0]);
  // An occlusion query has found more.
  update(2, 5000);
  expect(reported).toEqual([5, 0, 2]);
  update(1, 6000);
  expect(reported).toEqual([5, 0, 2]);
  vi.advanceTimersByTime(200);
  expect(reported).toEqual([5, 0, 2, 1]);
  reporter.close();
});
