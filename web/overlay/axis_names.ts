import type { StoreInfo } from "../stream/index.ts";

/** The formats whose coordinates are a patient's: x to the left, y to the back, z to the head. */
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

const words: Readonly<Record<string, string>> = {
  R: "right",
  L: "left",
  A: "anterior",
  P: "posterior",
  I: "inferior",
  S: "superior",
};

/** The name for a label that is read: "from the left", "from −x". */
export function viewName(name: string): string {
  const word = words[name];
  return word ? `View from ${word}` : `View from ${name}`;
}
