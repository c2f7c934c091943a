import type { OverlayTexts } from "./overlay.ts";

export const overlay: OverlayTexts = {
  viewFrom: (side) => `Ansicht von ${side}`,
  sides: {
    R: "rechts",
    L: "links",
    A: "vorn (anterior)",
    P: "hinten (posterior)",
    I: "unten (inferior)",
    S: "oben (superior)",
  },
  orientation: "Ausrichtung",
  scale: (length) => `Maßstab: Der Balken ist ${length} lang`,
  scaleTitle: "In der Entfernung des Drehpunkts",
  voxels: (count) => `${count} Voxel`,
  clipFaces: "Seiten des Schnittquaders",
  lowerFace: (axis) => `Untere ${axis}-Seite des Schnittquaders`,
  upperFace: (axis) => `Obere ${axis}-Seite des Schnittquaders`,
};
