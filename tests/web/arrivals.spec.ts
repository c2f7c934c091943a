/** How long a picture waits for data that are still to arrive. */
import { expect, test } from "vitest";
import { Arrivals } from "../../web/viewer/arrivals.ts";
import { openingProgress } from "../../web/viewer/layers_progress.ts";

const refining = (chunksToGo: number, bytesFetched = 0) => ({
  ...openingProgress,
  ...{ state: "refining" as const, chunksToGo, bytesFetched, bytesToGo: 1e6 },
});

test("the first picture waits for the first surfaces of all layers, but not for long", () => {
  let missing = 3;
  const arrivals = new Arrivals(() => missing);
  expect(arrivals.isBegun).toBe(false);
  arrivals.begin(1000);
  arrivals.begin(1100);
  expect(arrivals.isBegun).toBe(true);
  expect(arrivals.waitOfFirst(1100)).toBe(200);
  expect(arrivals.wait(1100, 10)).toBe(200);
  expect(arrivals.waitOfFirst(1300)).toBe(0);
  arrivals.pictureDrawn();
  expect(arrivals.waitOfFirst(1100)).toBe(0);
  arrivals.forget();
  arrivals.begin(1000);
  expect(arrivals.waitOfFirst(1100)).toBe(200);
  missing = 0;
  expect(arrivals.waitOfFirst(1100)).toBe(0);
});

test("the first picture waits longer while first surfaces keep arriving", () => {
  let missing = 1000;
  const arrivals = new Arrivals(() => missing);
  arrivals.begin(1000);
  for (let now = 1100; now < 2200; now += 100) {
    missing -= 10;
    expect(arrivals.waitOfFirst(now)).toBe(300);
  }
  missing -= 10;
  expect(arrivals.waitOfFirst(2300)).toBe(200);
  expect(arrivals.waitOfFirst(2400)).toBe(100);
  missing -= 10;
  expect(arrivals.waitOfFirst(2500)).toBe(0);
});

test("a layer that is added later does not hold up the picture", () => {
  let missing = 0;
  const arrivals = new Arrivals(() => missing);
  arrivals.begin(1000);
  missing = 1;
  expect(arrivals.wait(2000, 10)).toBeLessThanOrEqual(0);
});

test("new chunks wait for the duration of a picture, as long as more are expected", () => {
  const arrivals = new Arrivals(() => 0);
  arrivals.begin(0);
  expect(arrivals.progressed(10, refining(5))).toBe(false);
  arrivals.drawn(100, 40);
  expect(arrivals.areExpected).toBe(true);
  expect(arrivals.wait(110, 40)).toBe(30);
  expect(arrivals.wait(140, 40)).toBe(0);
  expect(arrivals.progressed(150, refining(0, 1e6))).toBe(true);
  expect(arrivals.areExpected).toBe(false);
  expect(arrivals.wait(110, 40)).toBe(0);
  arrivals.forget();
  expect(arrivals.isBegun).toBe(false);
});
