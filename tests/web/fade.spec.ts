// Tests by the calls of the renderer when pictures fade into each other.
import { expect, it } from "vitest";
import { Fade } from "../../web/viewer/fade.ts";
import type { RendererModule } from "../../web/viewer/renderer_module.ts";

function recorded(mayFade = () => true): { fade: Fade; calls: string[] } {
  const calls: string[] = [];
  const view = {
    holdPicture: () => calls.push("hold"),
    beginFade: () => {
      calls.push("begin");
      return true;
    },
    fade: (progress: number) => calls.push(`fade ${progress.toFixed(2)}`),
  };
  return { fade: new Fade(view as unknown as RendererModule, mayFade), calls };
}

it("fades from a picture to the picture with newly arrived data", () => {
  const { fade, calls } = recorded();
  fade.beforeDraw(0);
  fade.afterDraw(0, true);
  expect(calls).toEqual(["hold"]);
  expect(fade.isRunning).toBe(false);
  fade.beforeDraw(100);
  fade.afterDraw(100, false);
  expect(fade.isRunning).toBe(true);
  fade.step(140, false);
  fade.step(180, false);
  expect(fade.isRunning).toBe(true);
  fade.step(900, false);
  expect(fade.isRunning).toBe(false);
  expect(calls).toEqual(["hold", "begin", "fade 0.25", "fade 0.50", "fade 1.00"]);
  // No further data were expected, so the next picture shows another view or another look.
  fade.afterDraw(1000, false);
  expect(calls).toHaveLength(5);
});

it("continues from its present state when more data arrive in between", () => {
  const { fade, calls } = recorded();
  fade.afterDraw(0, true);
  fade.afterDraw(10, true);
  fade.step(90, true);
  fade.beforeDraw(90);
  fade.afterDraw(90, true);
  fade.step(170, true);
  expect(calls).toEqual(["hold", "begin", "fade 0.50", "fade 0.50", "hold", "begin", "fade 0.50"]);
});

it("releases the held picture when something moves", () => {
  const { fade, calls } = recorded();
  fade.afterDraw(0, true);
  fade.afterDraw(10, true);
  fade.forget();
  expect(fade.isRunning).toBe(false);
  fade.beforeDraw(20);
  fade.afterDraw(20, true);
  expect(calls).toEqual(["hold", "begin", "hold"]);
  expect(fade.isRunning).toBe(false);
});

it("fades to the first picture with occlusion, from the present picture drawn again", () => {
  const { fade, calls } = recorded();
  const draw = () => calls.push("draw");
  const drawOccluded = () => calls.push("draw occluded");
  fade.toOccluded(1000, draw, drawOccluded);
  expect(fade.isRunning).toBe(true);
  fade.step(1040, false);
  fade.step(1200, false);
  expect(fade.isRunning).toBe(false);
  const begun = ["draw", "hold", "draw occluded", "begin"];
  expect(calls).toEqual([...begun, "fade 0.25", "fade 1.00"]);
});

it("shows pictures at once to visitors who prefer reduced motion", () => {
  let mayFade = false;
  const { fade, calls } = recorded(() => mayFade);
  fade.afterDraw(0, true);
  fade.afterDraw(10, true);
  fade.toOccluded(
    20,
    () => calls.push("draw"),
    () => calls.push("draw occluded"),
  );
  expect(fade.isRunning).toBe(false);
  expect(calls).toEqual(["draw occluded"]);
  mayFade = true;
  fade.afterDraw(30, true);
  expect(calls).toEqual(["draw occluded", "hold"]);
});
