import type { slicesTexts as English } from "./slices.ts";

export const slices: typeof English = {
  across: (axis) => `Schicht quer zu ${axis}`,
  voxelOf: (axis) => `Voxel entlang ${axis}`,
  at: (voxel, length) => `Voxel ${voxel}, ${length}`,
  oblique: "Schräge Schicht",
  fromCentre: (length) => `${length} von der Mitte`,
  acrossView: "Schicht quer zur Ansicht",
  acrossViewTitle: "Eine schräge Schicht durch die Mitte des Volumens, Ihnen zugewandt",
  removeOblique: "Schräge Schicht entfernen",
  black: "Schwarz bei",
  white: "Weiß bei",
  lowest: "Farben von",
  highest: "Farben bis",
  colours: "Farben",
  grey: "Grau",
  wholeRange: "Ganzer Bereich",
  about:
    "Schichten zeigen die Werte der geladenen Zellen: nahe den Isowerten der Flächen in voller Auflösung, sonst gröber. Schraffierte Stellen haben keine geladenen Werte, oder ihre Werte ändern sich nicht (solche Zellen sind nicht gespeichert).",
};
