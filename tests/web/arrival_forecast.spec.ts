/**
 * The forecast of the time at which the missing chunks will have arrived, from the rate of the last
 * half second.
 */
import { expect, test } from "vitest";
import { ArrivalForecast } from "../../web/viewer/arrival_forecast.ts";

test("follows the present rate, not the mean since the beginning", () => {
  const forecast = new ArrivalForecast();
  expect(forecast.remaining(0)).toBe(Number.POSITIVE_INFINITY);
  forecast.add(0, 0, 300_000);
  expect(forecast.remaining(10)).toBe(Number.POSITIVE_INFINITY);
  // 10 KB in the first second, then 100 KB in each half.
  forecast.add(1000, 10_000, 290_000);
  forecast.add(1500, 110_000, 190_000);
  forecast.add(2000, 210_000, 90_000);
  expect(forecast.remaining(2000)).toBe(450);
});

test("expects no early arrival on a link that has stalled", () => {
  const forecast = new ArrivalForecast();
  forecast.add(0, 0, 200_000);
  forecast.add(100, 100_000, 100_000);
  expect(forecast.remaining(100)).toBe(100);
  expect(forecast.remaining(1000)).toBe(1000);
  forecast.forget();
  expect(forecast.remaining(1000)).toBe(Number.POSITIVE_INFINITY);
});

test("does not count the time in which nothing was missing", () => {
  const forecast = new ArrivalForecast();
  forecast.add(0, 0, 100_000);
  forecast.add(100, 100_000, 0);
  // In the meantime, nothing was missing: the result of an occlusion query was awaited.
  forecast.add(400, 100_000, 300_000);
  forecast.add(500, 200_000, 200_000);
  expect(forecast.remaining(500)).toBe(200);
});

test("expects a new request to be as fast as the last one, for a moment", () => {
  const forecast = new ArrivalForecast();
  forecast.add(0, 0, 100_000);
  forecast.add(100, 100_000, 0);
  forecast.add(1000, 100_000, 50_000);
  expect(forecast.remaining(1000)).toBe(150);
  expect(forecast.remaining(1060)).toBe(90);
  expect(forecast.remaining(1101)).toBe(Number.POSITIVE_INFINITY);
});

test("a picture waits for the last chunk if that takes no longer than three pictures", () => {
  const forecast = new ArrivalForecast();
  forecast.add(0, 0, 300_000);
  forecast.add(100, 100_000, 200_000);
  expect(forecast.wait(100, 50)).toBe(0);
  expect(forecast.wait(100, 100)).toBe(200);
  // It waits no longer than a second, unless one picture takes longer.
  forecast.add(200, 110_000, 1_000_000);
  expect(forecast.remaining(200)).toBeGreaterThan(1800);
  expect(forecast.wait(200, 900)).toBe(0);
  expect(forecast.wait(200, 2000)).toBe(forecast.remaining(200));
});
