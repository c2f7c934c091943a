import { expect, it } from "vitest";
import { cameraPath, sweep, throughTime, turntable } from "../../web/capture/frame_paths.ts";
import type { Camera } from "../../web/viewer/types.ts";

const camera: Camera = {
  target: [0, 0, 0],
  distance: 100,
  azimuth: 30,
  elevation: 20,
  roll: 0,
  fieldOfView: 30,
};
const surfaces = [10, 20].map((isovalue) => ({ isovalue, colour: "#d9ccb3", opacity: 1 }));
const view = { camera, surfaces };

it("turns once around, and repeats no view", () => {
  const frames = turntable(view, 4);
  expect(frames.map((frame) => frame.camera.azimuth)).toEqual([30, 120, 210, 300]);
  expect(frames.every((frame) => frame.surfaces === surfaces)).toBe(true);
});

it("sweeps one isovalue from the first to the last", () => {
  const frames = sweep(view, 1, [100, 40], 4);
  expect(frames.map((frame) => frame.surfaces.map(({ isovalue }) => isovalue))).toEqual([
    [10, 100],
    [10, 80],
    [10, 60],
    [10, 40],
  ]);
  expect(frames.every((frame) => frame.camera === camera)).toBe(true);
});

it("visits all views, with the same time from each view to the next", () => {
  const cameras = [0, 90, 60].map((elevation) => ({ ...camera, elevation }));
  const frames = cameraPath(cameras, view, 5);
  expect(frames.map((frame) => frame.camera.elevation)).toEqual([0, 45, 90, 75, 60]);
  // It is slow at the ends of each part.
  const [first, second] = cameraPath(cameras.slice(0, 2), view, 11).map((f) => f.camera.elevation);
  expect([first, second]).toEqual([0, expect.closeTo(90 * 0.028, 6)]);
});

it("shows each step of a scene for the same time", () => {
  const steps = (count: number, frames: number) =>
    throughTime(view, count, frames).map(({ step }) => step);
  expect(steps(3, 6)).toEqual([0, 0, 1, 1, 2, 2]);
  expect(steps(3, 4)).toEqual([0, 0, 1, 2]);
  expect(steps(4, 2)).toEqual([0, 2]);
  expect(throughTime(view, 3, 6).every((frame) => frame.camera === camera)).toBe(true);
});
