/** Playing: the times at which steps are shown, on a clock that the tests advance. */
import { beforeEach, describe, expect, test, vi } from "vitest";
import { Time } from "../../web/viewer/time.ts";
import { fakeClock } from "./fake_clock.ts";

fakeClock();

/** Layers for which the tests set the steps that have a surface. */
class Layers {
  readonly showable = new Set([0, 1, 2, 3]);
  readonly shown: number[] = [];
  readonly events: string[] = [];
  /** Whether each step is drawn at once. */
  draws = true;
  readonly time: Time = new Time({ values: [0, 2, 4, 8], unit: "s" }, 0, {
    isShowable: (step) => this.showable.has(step),
    show: (step) => {
      this.shown.push(step);
      if (this.draws) setTimeout(() => this.time.drawn(), 1);
      return true;
    },
    changed: () => {},
    cost: () => undefined,
    cellPixels: () => 1,
  });

  constructor() {
    this.time.rate = 10;
    this.time.on("play", (is) => this.events.push(is ? "play" : "pause"));
    this.time.on("buffering", (is) => this.events.push(is ? "waits" : "goes on"));
    this.time.on("step", (step) => this.events.push(`${step}`));
  }
}

let layers: Layers;
let time: Time;
beforeEach(() => {
  layers = new Layers();
  time = layers.time;
});

describe("a step", () => {
  test("that has a surface is shown at once", async () => {
    await time.setStep(2);
    expect(time.step).toBe(2);
    expect(layers.events).toEqual(["2"]);
  });

  test("that has no surface yet is shown when it has one, and the previous step stays until then", async () => {
    layers.showable.delete(2);
    const shown = time.setStep(2);
    expect([time.step, time.wantedStep, time.isBuffering]).toEqual([0, 2, true]);
    time.arrived();
    expect(time.step).toBe(0);
    layers.showable.add(2);
    time.arrived();
    await shown;
    expect([time.step, time.wantedStep, time.isBuffering]).toEqual([2, 2, false]);
    expect(layers.events).toEqual(["waits", "goes on", "2"]);
  });

  test("is abandoned if another one is set", async () => {
    layers.showable.delete(2);
    const shown = time.setStep(2);
    await time.setStep(3);
    await shown;
    expect(layers.shown).toEqual([3]);
    layers.showable.add(2);
    time.arrived();
    expect(layers.shown).toEqual([3]);
    layers.showable.delete(1);
    void time.setStep(1);
    await time.setStep(3);
    expect(time.isBuffering).toBe(false);
  });

  test("must exist", () => {
    for (const step of [-1, 4, 0.5, Number.NaN]) {
      expect(() => time.setStep(step)).toThrow(RangeError);
    }
    for (const rate of [0, -1, 61, Number.NaN]) {
      expect(() => {
        time.rate = rate;
      }).toThrow(RangeError);
    }
  });
});

describe("playing", () => {
  const pass = (milliseconds: number) => {
    vi.advanceTimersByTime(milliseconds);
    return layers.shown;
  };

  test("shows each step for its time", () => {
    time.play();
    expect(pass(99)).toEqual([]);
    expect(pass(2)).toEqual([1]);
    expect(pass(1000)).toEqual([1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3]);
    time.pause();
    expect(pass(1000).length).toBe(11);
    expect(layers.events[0]).toBe("play");
    expect(layers.events.at(-1)).toBe("pause");
  });

  test("swings, or ends, and begins again", () => {
    time.mode = "swing";
    time.play();
    expect(pass(701)).toEqual([1, 2, 3, 2, 1, 0, 1]);
    time.pause();
    time.mode = "once";
    time.play();
    expect(pass(1000).slice(7)).toEqual([2, 3]);
    expect(time.isPlaying).toBe(false);
    time.play();
    expect(pass(1000).slice(9)).toEqual([0, 1, 2, 3]);
  });

  test("skips no step, however slowly steps are drawn", () => {
    layers.draws = false;
    time.play();
    expect(pass(1000)).toEqual([1]);
    time.drawn();
    expect(pass(1)).toEqual([1, 2]);
    time.drawn();
    // The delay is not made up by showing the next steps faster.
    expect(pass(50)).toEqual([1, 2]);
    expect(pass(50)).toEqual([1, 2, 3]);
  });

  test("waits for a step without a surface, and goes on at its rate", () => {
    layers.showable.delete(2);
    time.play();
    expect(pass(1000)).toEqual([1]);
    expect(time.isBuffering).toBe(true);
    layers.showable.add(2);
    time.arrived();
    expect(pass(99)).toEqual([1, 2]);
    expect(pass(2)).toEqual([1, 2, 3]);
    expect(layers.events.filter((event) => /[a-z]/.test(event))).toEqual([
      "play",
      "waits",
      "goes on",
    ]);
  });

  test("continues from a step that was set", async () => {
    time.play();
    pass(101);
    await time.setStep(3);
    expect(pass(99)).toEqual([1, 3]);
    expect(pass(2)).toEqual([1, 3, 0]);
  });

  test("can be paused while it waits", () => {
    layers.showable.delete(1);
    time.play();
    pass(200);
    time.pause();
    expect([time.isBuffering, time.wantedStep]).toEqual([false, 0]);
    layers.showable.add(1);
    time.arrived();
    expect(pass(1000)).toEqual([]);
  });

  test("changes its rate at once", () => {
    time.rate = 0.1;
    time.play();
    expect(pass(1000)).toEqual([]);
    time.rate = 10;
    expect(pass(101)).toEqual([1]);
  });

  test("ends with its viewer", () => {
    time.play();
    time.close();
    expect(pass(1000)).toEqual([]);
  });
});
