import type { StoreInfo } from "../core/types.ts";
import { type OverlayTexts, overlayTexts } from "../texts/overlay.ts";

/** The colours of x, y and z. */
export const axisColours = ["#c8423a", "#3f8f3f", "#3d6fd0"] as const;

/** The formats with patient coordinates: x to the left, y to the back, z to the head. */
const anatomicalFormats = new Set(["DICOM", "NIfTI"]);

/** False if a note of the import doubts the sides. */
export function isAnatomical({ metadata }: StoreInfo): boolean {
  const format = metadata.source?.format;
  const isDoubtful = metadata.notes?.some((note) => note.includes("left and right may be swapped"));
  return typeof format === "string" && anatomicalFormats.has(format) && !isDoubtful;
}

/** The names of the ends of the world's axes: [negative, positive] of x, y, z. */
export function axisNames(info: StoreInfo): readonly (readonly [string, string])[] {
  if (isAnatomical(info)) {
    return [
      ["R", "L"],
      ["A", "P"],
      ["I", "S"],
    ];
  }
  return [
    ["−x", "x"],
    ["−y", "y"],
    ["−z", "z"],
  ];
}

/** The name for labels of screen readers: "from the left", "from −x". */
export function viewName(name: string, texts: OverlayTexts = overlayTexts): string {
  const sides: Readonly<Record<string, string>> = texts.sides;
  return texts.viewFrom(sides[name] ?? name);
}
