import { plurals } from "./numbers.ts";
import { part } from "./part.ts";

const plural = plurals("en");

/** The bar of scenes that change with time. */
export const timeTexts = part("time", {
  time: "Time",
  play: "Play (K)",
  pause: "Pause (K)",
  back: "One step back (,)",
  forth: "One step forward (.)",
  step: (step: number, steps: number) => `step ${step} of ${steps}`,
  rate: "Steps per second",
  rates: (rate: string) => `${rate} per second`,
  order: "After the last step",
  modes: { loop: "Loop", swing: "Back and forth", once: "Once" },
  waits: "waiting for data",
  costTitle: "What all steps of these isovalues take at full detail, if they have not been fetched",
  cost: (steps: number, bytes: string) =>
    plural(steps, { one: `${steps} step, ${bytes}`, other: `${steps} steps, ${bytes}` }),
  about: (bytes: string) => `about ${bytes}`,
  atFullDetail: (cost: string) => `${cost} at full detail`,
  coarser: "plays coarser, so that it does not stop at your connection's speed",
});
