import { part } from "./part.ts";

/** What lies above the picture, of the page or of an element, which may have another language. */
export const overlayTexts = part("overlay", {
  viewFrom: (side: string) => `View from ${side}`,
  /** The sides of a patient. */
  sides: {
    R: "right",
    L: "left",
    A: "anterior",
    P: "posterior",
    I: "inferior",
    S: "superior",
  },
  orientation: "Orientation",
  scale: (length: string) => `Scale: the bar is ${length} long`,
  scaleTitle: "At the distance of the centre of rotation",
  voxels: (count: string) => (count === "1" ? "1 voxel" : `${count} voxels`),
  clipFaces: "Faces of the clip box",
  lowerFace: (axis: string) => `Lower ${axis} face of the clip box`,
  upperFace: (axis: string) => `Upper ${axis} face of the clip box`,
});
export type OverlayTexts = typeof overlayTexts;
