/** Dark or light: the system's choice, until the visitor makes one, which this browser remembers. */
export type Theme = "light" | "dark";

/** What surfaces are drawn on, unless another colour is chosen. */
export const themeBackground: Readonly<Record<Theme, string>> = {
  light: "#eef0f3",
  dark: "#15181d",
};

const storageKey = "isosplat-theme";
const systemDark = matchMedia("(prefers-color-scheme: dark)");
const listeners = new Set<() => void>();

function chosen(): Theme | null {
  try {
    const value = localStorage.getItem(storageKey);
    return value === "light" || value === "dark" ? value : null;
  } catch {
    return null; // storage can be switched off
  }
}

export function theme(): Theme {
  return chosen() ?? (systemDark.matches ? "dark" : "light");
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
    // Back to what the system says means: follow the system again.
    if (next === system) localStorage.removeItem(storageKey);
    else localStorage.setItem(storageKey, next);
  } catch {
    document.documentElement.classList.toggle("wa-dark");
    return;
  }
  apply();
}

/** Calls the listener when the theme has changed; the answer removes it. */
export function onTheme(listener: () => void): () => void {
  listeners.add(listener);
  return () => listeners.delete(listener);
}

export function startTheme(): void {
  systemDark.addEventListener("change", apply);
  apply();
}
