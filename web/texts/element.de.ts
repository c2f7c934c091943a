import type { ElementTexts } from "./element.ts";

export { overlay } from "./overlay.de.ts";

export const element: ElementTexts = {
  isosurface: "Isofläche",
  view3d: "3D-Ansicht",
  isovalue: "Isowert",
  isovalueAsNumber: "Isowert als Zahl",
  fit: "Einpassen",
  fitTitle: "Das ganze Volumen zeigen",
  fullScreen: "Vollbild",
  fullScreenTitle: "Nur diese Ansicht zeigen",
  time: "Zeit",
  play: "Abspielen",
  pause: "Anhalten",
  rate: "Schritte je Sekunde",
  loop: "Nach dem letzten Schritt",
  loops: { loop: "Von vorn", swing: "Hin und her", once: "Einmal" },
};
