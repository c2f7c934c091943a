/**
 * Dark or light: the system's setting, unless the visitor has chosen one; the browser stores the
 * choice.
 */
export type Theme = "light" | "dark";

/** The default background of surfaces. */
export const themeBackground: Readonly<Record<Theme, string>> = {
  light: "#eef0f3",
  dark: "#15181d",
};

const storageKey = "isosplat-theme";
const systemDark = matchMedia("(prefers-color-scheme: dark)");
const listeners = new Set<() => void>();

function storedTheme(): Theme | null {
  try {
    const value = localStorage.getItem(storageKey);
    return value === "light" || value === "dark" ? value : null;
  } catch {
    return null; // storage may be disabled
  }
}

export function theme(): Theme {
  return storedTheme() ?? (systemDark.matches ? "dark" : "light");
}

function apply(): void {
  document.documentElement.classList.toggle("wa-dark", theme() === "dark");
  document.documentElement.classList.toggle("wa-light", theme() === "light");
  for (const listener of listeners) listener();
}

export function toggleTheme(): void {
  const next: Theme = theme() === "dark" ? "light" : "dark";
  const system: Theme = systemDark.matches ? "dark" : "light";
  try {
    // If the choice equals the system's setting, the page follows the system again.
    if (next === system) localStorage.removeItem(storageKey);
    else localStorage.setItem(storageKey, next);
  } catch {
    document.documentElement.classList.toggle("wa-dark");
    return;
  }
  apply();
}

/** Calls the listener when the theme has changed; the returned function removes it. */
export function onTheme(listener: () => void): () => void {
  listeners.add(listener);
  return () => listeners.delete(listener);
}

export function startTheme(): void {
  systemDark.addEventListener("change", apply);
  apply();
}
