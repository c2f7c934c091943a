/** The parts of the page, each of which is loaded with its texts. */
export type PartName =
  | "capture"
  | "device"
  | "deviceError"
  | "fault"
  | "help"
  | "layers"
  | "measure"
  | "overlay"
  | "page"
  | "panel"
  | "session"
  | "slices"
  | "start"
  | "surface"
  | "time";

/** The texts of all parts in another language, each of the type of the English ones. */
export type Translation = Readonly<Record<PartName, object>>;

const parts = new Map<PartName, object>();
let translation: Partial<Translation> = {};

/**
 * The texts of a part of the page. They are English until `translate` puts those of another language in
 * their place, in the same object: read a text when it is shown, and do not keep it in a constant.
 */
export function part<Texts extends object>(name: PartName, english: Texts): Texts {
  parts.set(name, english);
  return Object.assign(english, translation[name]);
}

/** Translates all parts: those that are loaded, and each other one when it is loaded. */
export function translate(to: Translation): void {
  translation = to;
  for (const [name, texts] of parts) Object.assign(texts, to[name]);
}
