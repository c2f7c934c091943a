import { firstKnown, type Language, type OtherLanguage } from "./languages.ts";
import { writeNumbersAs } from "./numbers.ts";
import { type Translation, translate } from "./part.ts";

interface Files {
  texts: () => Promise<{ translation: Translation }>;
  /** Of the component library. */
  components: () => Promise<unknown>;
}

/** The modules with the texts of the other languages. */
const files: Readonly<Record<OtherLanguage, Files>> = {
  de: {
    texts: () => import("./de.ts"),
    components: () => import("@awesome.me/webawesome/dist/translations/de.js"),
  },
};

const storageKey = "isosplat-language";
let current: Language = "en";

/** The language of the page. */
export function language(): Language {
  return current;
}

/**
 * Puts the page into the visitor's language: that of the address (`lang=de`), which is kept on the
 * device; else the one that is kept; else the browser's. The page stays English if its texts cannot
 * be loaded. Call it before anything is shown.
 */
export async function startLanguage(): Promise<void> {
  const requested = firstKnown([new URLSearchParams(location.search).get("lang") ?? ""]);
  if (requested) keep(requested);
  const chosen = requested ?? firstKnown([kept()]) ?? firstKnown(navigator.languages) ?? "en";
  if (chosen === "en") return;
  try {
    translate((await files[chosen].texts()).translation);
  } catch {
    return;
  }
  current = chosen;
  document.documentElement.lang = chosen;
  writeNumbersAs(chosen);
}

/** Translates the components; they show it when it has come. */
export function translateComponents(): void {
  if (current !== "en") files[current].components().catch(() => {}); // they stay English
}

/** Loads the page again in another language. */
export function chooseLanguage(chosen: Language): void {
  const query = new URLSearchParams(location.search);
  const isKept = keep(chosen);
  // A language in the address has precedence, so it is removed. If the choice cannot be kept in the
  // browser, the address must state it.
  if (isKept && !query.has("lang")) location.reload();
  else {
    query.delete("lang");
    if (!isKept) query.set("lang", chosen);
    location.search = String(query);
  }
}

function kept(): string {
  try {
    return localStorage.getItem(storageKey) ?? "";
  } catch {
    return ""; // storage may be disabled
  }
}

function keep(chosen: Language): boolean {
  try {
    localStorage.setItem(storageKey, chosen);
    return true;
  } catch {
    return false;
  }
}
