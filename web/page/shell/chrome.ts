import { html, nothing, type TemplateResult } from "lit";
import { chooseLanguage, language } from "../../texts/language.ts";
import { type Language, languages } from "../../texts/languages.ts";
import { pageTexts } from "../../texts/page.ts";
import { type IconName, icon } from "./icons.ts";
import type { Problem } from "./problems.ts";
import { theme, toggleTheme } from "./theme.ts";

/** Parts that all views of the page share: the logo, the theme button, messages. */

export function brand(): TemplateResult {
  return html`<a class="brand" href="./" aria-label=${pageTexts.home}>
    <svg viewBox="0 0 32 32" aria-hidden="true" class="mark">
      <path d="M16 2.5 27.7 9.2v13.6L16 29.5 4.3 22.8V9.2Z" class="mark-cell" />
      <path d="M4.3 20.5C9 14 12.5 23 17.5 17.5S23 8 27.7 11.5V22.8L16 29.5 4.3 22.8Z" class="mark-surface" />
    </svg>
    <span class="wordmark">Isosplat</span>
  </a>`;
}

export interface IconAction {
  icon: IconName;
  label: string;
  action: () => void;
  isDisabled?: boolean;
  /** Hidden in narrow windows. */
  isMinor?: boolean;
}

export function iconButton(button: IconAction): TemplateResult {
  const { icon: name, label, action, isDisabled = false, isMinor = false } = button;
  return html`<wa-button
    class=${isMinor ? "icon-button minor" : "icon-button"}
    appearance="plain"
    size="s"
    title=${label}
    ?disabled=${isDisabled}
    @click=${action}
    ><span class="visually-hidden">${label}</span>${icon(name)}</wa-button
  >`;
}

export function themeButton(isMinor = false): TemplateResult {
  const isDark = theme() === "dark";
  return iconButton({
    icon: isDark ? "sun" : "moon",
    label: isDark ? pageTexts.lightTheme : pageTexts.darkTheme,
    action: toggleTheme,
    isMinor,
  });
}

/** Chooses the page's language. Each language is listed by its own name. */
export function languageChoice(): TemplateResult {
  const names = Object.entries(languages) as [Language, string][];
  return html`<select
    class="language"
    aria-label=${pageTexts.language}
    autocomplete="off"
    @change=${(event: Event) =>
      chooseLanguage((event.currentTarget as HTMLSelectElement).value as Language)}
  >
    ${names.map(
      ([code, name]) =>
        html`<option value=${code} lang=${code} ?selected=${code === language()}>${name}</option>`,
    )}
  </select>`;
}

export interface ProblemActions {
  retry: () => void;
  /** The volumes or scenes that the visitor can open instead, if the server's list is available. */
  others?: readonly ListedName[];
}

/** A volume or a scene of the server, by the parameter of the page that opens it. */
export interface ListedName {
  kind: "volume" | "scene";
  name: string;
}

export function problemCard(problem: Problem, actions: ProblemActions): TemplateResult {
  return html`<section class="problem" role="alert">
    <div class="problem-icon">${icon(problem.icon)}</div>
    <h2>${problem.title}</h2>
    <p>${problem.text}</p>
    ${
      actions.others && actions.others.length > 0
        ? html`<nav class="problem-names" aria-label=${pageTexts.onThisServer}>
            ${actions.others.map(
              ({ kind, name }) =>
                html`<a class="chip" href="?${kind}=${encodeURIComponent(name)}">${name}</a>`,
            )}
          </nav>`
        : nothing
    }
    <div class="problem-actions">
      ${
        problem.offers.includes("again")
          ? html`<wa-button variant="brand" size="s" @click=${actions.retry}>${pageTexts.again}</wa-button>`
          : nothing
      }
      ${
        problem.offers.includes("reload")
          ? html`<wa-button variant="brand" size="s" @click=${() => location.reload()}
              >${pageTexts.loadAnew}</wa-button
            >`
          : nothing
      }
      ${
        problem.offers.includes("volumes")
          ? html`<wa-button appearance="outlined" size="s" href="./">${pageTexts.allVolumes}</wa-button>`
          : nothing
      }
    </div>
    ${
      problem.detail
        ? html`<details class="problem-detail">
            <summary>${pageTexts.details}</summary>
            <code>${problem.detail}</code>
          </details>`
        : nothing
    }
  </section>`;
}
