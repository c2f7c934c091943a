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
  costTitle:
    "The data of all steps for these isovalues at full detail, if nothing has been fetched yet",
  cost: (steps: number, bytes: string) =>
    plural(steps, { one: `${steps} step, ${bytes}`, other: `${steps} steps, ${bytes}` }),
  about: (bytes: string) => `about ${bytes}`,
  atFullDetail: (cost: string) => `${cost} at full detail`,
  coarser: "plays with less detail, so that it does not stop at the speed of your connection",
});
