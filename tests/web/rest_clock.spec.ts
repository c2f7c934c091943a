/** The time from which a view is at rest and is drawn exactly. */
import { expect, test } from "vitest";
import { RestClock } from "../../web/viewer/rest_clock.ts";

test("a view rests 0.22 s after the last of several changes, and soon after the last arrival", () => {
  const clock = new RestClock();
  clock.moved(900);
  clock.moved(1000);
  clock.arrived(900);
  expect(clock.restsAt).toBe(1220);
  expect(clock.isMoving(1219)).toBe(true);
  expect(clock.isMoving(1220)).toBe(false);
  clock.arrived(1500);
  expect(clock.restsAt).toBe(1560);
});

test("a single change is no movement, but the view waits for the next change of a gesture", () => {
  const clock = new RestClock();
  clock.moved(1000);
  expect(clock.isMoving(1000)).toBe(false);
  expect(clock.restsAt).toBe(1060);
  clock.moved(1050);
  expect(clock.isMoving(1051)).toBe(true);
  expect(clock.restsAt).toBe(1270);
  clock.moved(1500);
  expect(clock.isMoving(1500)).toBe(false);
});

test("while data are in flight, it rests later", () => {
  const clock = new RestClock();
  clock.isStreaming = true;
  clock.moved(900);
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
  expect(clock.restsAt).toBe(1060);
});
