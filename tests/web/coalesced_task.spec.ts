// A coalesced task runs the requested work soon, in a separate task, once for all requests.
import { afterEach, beforeEach, expect, it, vi } from "vitest";
import { CoalescedTask } from "../../web/stream/coalesced_task.ts";

beforeEach(() => {
  vi.useFakeTimers();
});
afterEach(() => {
  vi.useRealTimers();
});

it("runs once, later, for all requests", () => {
  const work = vi.fn();
  const task = new CoalescedTask(work);
  task.request();
  task.request();
  expect(work).not.toHaveBeenCalled();
  expect(task.isRequested).toBe(true);
  vi.runAllTimers();
  expect(work).toHaveBeenCalledTimes(1);
  expect(task.isRequested).toBe(false);
});

it("can be requested again by the work itself, and be cancelled", () => {
  const task: CoalescedTask = new CoalescedTask(() => {
    if (++done < 3) task.request();
  });
  let done = 0;
  task.request();
  vi.runAllTimers();
  expect(done).toBe(3);
  task.request();
  task.cancel();
  vi.runAllTimers();
  expect(done).toBe(3);
});
