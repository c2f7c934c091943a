/** The time from which a view is at rest and is drawn exactly. */
import { expect, test } from "vitest";
import { RestClock } from "../../web/viewer/rest_clock.ts";

test("a view rests 0.22 s after the last motion or arrival", () => {
  const clock = new RestClock();
  clock.moved(1000);
  clock.arrived(900);
  expect(clock.restsAt).toBe(1220);
  expect(clock.isMoving(1219)).toBe(true);
  expect(clock.isMoving(1220)).toBe(false);
  clock.arrived(1500);
  expect(clock.restsAt).toBe(1720);
});

test("while data are in flight, it rests later", () => {
  const clock = new RestClock();
  clock.isStreaming = true;
  clock.moved(1000);
  expect(clock.restsAt).toBe(1500);
  // The occlusion query runs before.
  expect(clock.movesUntil).toBe(1220);
  clock.arrived(1000);
  expect(clock.restsAt).toBe(2500);
});

test("a view whose fast picture took long does not rest before its requested chunks have arrived", () => {
  const clock = new RestClock();
  clock.isStreaming = true;
  clock.arrived(1000);
  clock.fastPictureTested(3000);
  expect(clock.restsAt).toBeGreaterThan(3000);
  // The chunks arrive, and the query of the next fast picture requests no more.
  clock.arrived(3300);
  clock.fastPictureTested(4000);
  clock.restNow();
  expect(clock.restsAt).toBeLessThanOrEqual(4000);
});

test("a complete view rests although it was tested just now", () => {
  const clock = new RestClock();
  clock.arrived(1000);
  clock.fastPictureTested(3000);
  expect(clock.restsAt).toBe(1220);
});
