import type { Language, OtherLanguage } from "./languages.ts";
import type { OverlayTexts } from "./overlay.ts";

/** The element's own texts. Elements of one page may have different languages. */
export const elementTexts = {
  isosurface: "Isosurface",
  view3d: "3D view",
  isovalue: "Isovalue",
  isovalueAsNumber: "Isovalue as a number",
  fit: "Fit",
  fitTitle: "Show the whole volume",
  fullScreen: "Full screen",
  fullScreenTitle: "Show only this view",
  time: "Time",
  play: "Play",
  pause: "Pause",
  rate: "Steps per second",
  loop: "After the last step",
  loops: { loop: "Loop", swing: "Back and forth", once: "Once" },
};
export type ElementTexts = typeof elementTexts;

export interface TextsOfElement {
  element: ElementTexts;
  /** The texts of the overlays; undefined: English, which is loaded with them. */
  overlay?: OverlayTexts;
}

/** The modules with the texts of the other languages. */
const files: Readonly<Record<OtherLanguage, () => Promise<TextsOfElement>>> = {
  de: () => import("./element.de.ts"),
};

/** Resolves to the English texts if the others cannot be loaded. */
export async function elementTextsIn(language: Language): Promise<TextsOfElement> {
  const english = { element: elementTexts };
  if (language === "en") return english;
  try {
    return await files[language]();
  } catch {
    return english;
  }
}
