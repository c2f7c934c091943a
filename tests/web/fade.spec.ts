// When pictures fade into each other, according to the calls of the renderer.
import { expect, it } from "vitest";
import { Fade } from "../../web/viewer/fade.ts";
import type { RendererModule } from "../../web/viewer/renderer_module.ts";

function recorded(): { fade: Fade; calls: string[] } {
  const calls: string[] = [];
  const view = {
    holdPicture: () => calls.push("hold"),
    beginFade: () => {
      calls.push("begin");
      return true;
    },
    fade: (progress: number) => calls.push(`fade ${progress.toFixed(2)}`),
  };
  return { fade: new Fade(view as unknown as RendererModule), calls };
}

it("fades from a picture to the one that what arrives makes of it", () => {
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

it("goes on from where it is when more arrives in between", () => {
  const { fade, calls } = recorded();
  fade.afterDraw(0, true);
  fade.afterDraw(10, true);
  fade.step(90, true);
  fade.beforeDraw(90);
  fade.afterDraw(90, true);
  fade.step(170, true);
  expect(calls).toEqual(["hold", "begin", "fade 0.50", "fade 0.50", "hold", "begin", "fade 0.50"]);
});

it("lets go of what is held when something moves", () => {
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
