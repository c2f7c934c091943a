import { html, type TemplateResult } from "lit";

/** An element of Web Awesome that has a value. */
export type ValueElement = HTMLElement & { value: string };

/** A slider renders again if its formatter is a different function, so this is a constant. */
export const percent = (share: number) => `${Math.round(share * 100)} %`;

/** A drop-down list. `choices`: the label of each value. */
export function select(
  label: string,
  value: string,
  choices: Readonly<Record<string, string>>,
  changed: (value: string) => void,
  hint = "",
): TemplateResult {
  return html`<wa-select
    size="s"
    label=${label}
    hint=${hint}
    .value=${value}
    @change=${(event: Event) => changed((event.currentTarget as ValueElement).value)}
  >
    ${Object.entries(choices).map(([value, label]) => html`<wa-option value=${value}>${label}</wa-option>`)}
  </wa-select>`;
}

/** A slider with its value beside its label. Its formatter speaks the value, so screen readers skip the text. */
export function withValue(slider: TemplateResult, value: string): TemplateResult {
  return html`<div class="with-value">
    ${slider}<span class="slider-value quiet" aria-hidden="true">${value}</span>
  </div>`;
}
