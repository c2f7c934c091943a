import { afterEach, beforeEach, expect, it, vi } from "vitest";
import { followInterval, LayoutPace } from "../../web/page/volume/layout_pace.ts";

const frame = 16;
let shown: string[] = [];
let pace: LayoutPace;

function frames(count: number): void {
  for (let i = 0; i < count; ++i) vi.advanceTimersByTime(frame);
}

beforeEach(() => {
  vi.useFakeTimers({ toFake: ["setTimeout", "clearTimeout", "performance"] });
  vi.stubGlobal("requestAnimationFrame", (callback: () => void) => setTimeout(callback, frame));
  vi.stubGlobal("cancelAnimationFrame", clearTimeout);
  shown = [];
  pace = new LayoutPace(
    () => {
      pace.laidOut();
      shown.push("page");
    },
    () => shown.push("isovalue"),
  );
});

afterEach(() => {
  vi.unstubAllGlobals();
  vi.useRealTimers();
});

it("lays the page out once in the next frame", () => {
  pace.request();
  pace.request();
  expect(shown).toEqual([]);
  frames(2);
  expect(shown).toEqual(["page"]);
});

it("lays the page out in the next frame after a single change of the isovalue", () => {
  pace.request(true);
  frames(2);
  expect(shown).toEqual(["page"]);
});

it("shows each isovalue of a movement in the next frame, and all else now and then", () => {
  const changes = Math.ceil((2.5 * followInterval) / frame);
  for (let i = 0; i < changes; ++i) {
    pace.request(true);
    frames(1);
  }
  const pages = shown.filter((what) => what === "page").length;
  expect(shown.length).toBeGreaterThanOrEqual(changes - 1);
  expect(pages).toBeGreaterThanOrEqual(2);
  expect(pages).toBeLessThanOrEqual(4);
});

it("lays the page out after the last isovalue of a movement", () => {
  pace.request(true);
  frames(1);
  pace.request(true);
  frames(1);
  expect(shown).toEqual(["page", "isovalue"]);
  vi.advanceTimersByTime(followInterval + frame);
  expect(shown).toEqual(["page", "isovalue", "page"]);
  vi.advanceTimersByTime(10 * followInterval);
  expect(shown).toHaveLength(3);
});

it("lays the page out in the next frame if something else has changed during a movement", () => {
  pace.request(true);
  frames(1);
  pace.request(true);
  pace.request();
  frames(1);
  expect(shown).toEqual(["page", "page"]);
  vi.advanceTimersByTime(10 * followInterval);
  expect(shown).toHaveLength(2);
});
