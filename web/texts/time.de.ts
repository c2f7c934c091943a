import { plurals } from "./numbers.ts";
import type { timeTexts as English } from "./time.ts";

const plural = plurals("de");

export const time: typeof English = {
  time: "Zeit",
  play: "Abspielen (K)",
  pause: "Anhalten (K)",
  back: "Einen Schritt zurück (,)",
  forth: "Einen Schritt vor (.)",
  step: (step, steps) => `Schritt ${step} von ${steps}`,
  rate: "Schritte je Sekunde",
  rates: (rate) => `${rate} je Sekunde`,
  order: "Nach dem letzten Schritt",
  modes: { loop: "Von vorn", swing: "Hin und her", once: "Einmal" },
  waits: "wartet auf Daten",
  costTitle:
    "Die Daten aller Schritte für diese Isowerte in voller Auflösung, wenn noch nichts geladen ist",
  cost: (steps, bytes) =>
    plural(steps, { one: `${steps} Schritt, ${bytes}`, other: `${steps} Schritte, ${bytes}` }),
  about: (bytes) => `etwa ${bytes}`,
  atFullDetail: (cost) => `${cost} in voller Auflösung`,
  coarser:
    "läuft mit weniger Details, damit es bei der Geschwindigkeit Ihrer Verbindung nicht stockt",
};
