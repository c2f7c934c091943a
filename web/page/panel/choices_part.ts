import { html, nothing, type TemplateResult } from "lit";
import { styleMap } from "lit/directives/style-map.js";
import { panelTexts } from "../../texts/panel.ts";
import { formatValue } from "../shell/format.ts";
import type { IsovalueChoice } from "./isovalue_choices.ts";

/** What the buttons of the offered isovalues show. */
export interface ChoicesState {
  choices: readonly IsovalueChoice[];
  /** The isovalue of the active surface, and its colour, which the pictures get. */
  isovalue: number;
  colour: string;
  units: string | undefined;
  /** The URL of each choice's picture, undefined until it is drawn; null: the buttons have no pictures. */
  pictures: readonly (string | undefined)[] | null;
}

/** Buttons that choose an isovalue. */
export function choicesPart(
  { choices, isovalue, colour, units, pictures }: ChoicesState,
  choose: (isovalue: number) => void,
): TemplateResult | typeof nothing {
  if (choices.length === 0) return nothing;
  const button = (choice: IsovalueChoice, i: number) => {
    const value = formatValue(choice.isovalue);
    const name = nameOf(choice);
    const full = units ? `${value} ${units}` : value;
    const picture = pictures?.[i];
    return html`<button
      class=${pictures ? "chip choice" : "chip"}
      type="button"
      aria-label=${name ? `${name}, ${full}` : full}
      aria-pressed=${choice.isovalue === isovalue}
      @click=${() => choose(choice.isovalue)}
    >
      ${pictures ? html`<span class="choice-picture">${picture ? surfaceOf(picture, colour) : nothing}</span>` : nothing}
      <span>${value}</span>
      ${name ? html`<span class="choice-name">${name}</span>` : nothing}
    </button>`;
  };
  return html`<div class=${pictures ? "chips choices" : "chips"} role="group" aria-label=${panelTexts.suggested}>
    ${choices.map(button)}
  </div>`;
}

/** What the isovalue shows, or its usual notation; undefined if there is no convention. */
function nameOf({ tissue, deviations }: IsovalueChoice): string | undefined {
  if (tissue) return panelTexts.tissues[tissue];
  return deviations === undefined ? undefined : `${formatValue(Number(deviations.toFixed(1)))} σ`;
}

/** A picture of a white surface in this colour. */
function surfaceOf(picture: string, colour: string): TemplateResult {
  const mask = `url("${picture}")`;
  return html`<span
    class="choice-surface"
    style=${styleMap({ "background-color": colour, "mask-image": mask })}
    ><img src=${picture} alt=""
  /></span>`;
}
