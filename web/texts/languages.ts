/** The languages that there are texts in, each with its own name. English is always there. */
export const languages = { en: "English", de: "Deutsch" } as const;
export type Language = keyof typeof languages;
export type OtherLanguage = Exclude<Language, "en">;

/** The first of these languages (BCP 47: `de-AT`) that has texts; undefined if none has. */
export function firstKnown(wanted: readonly string[]): Language | undefined {
  const known = Object.keys(languages) as Language[];
  for (const each of wanted) {
    const [base] = each.toLowerCase().split("-");
    const found = known.find((language) => language === base);
    if (found) return found;
  }
  return undefined;
}
