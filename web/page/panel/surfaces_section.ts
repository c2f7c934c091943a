import { html, type TemplateResult } from "lit";
import { panelTexts } from "../../texts/panel.ts";
import { maxSurfaces, type Surface } from "../../viewer/types.ts";
import { formatValue } from "../shell/format.ts";
import { icon } from "../shell/icons.ts";
import { percent, type ValueElement } from "./form_elements.ts";
import type { VolumeActions, VolumeState } from "./panel_state.ts";

/** The list of surfaces: colour, isovalue and opacity of each. */
export function surfacesSection(state: VolumeState, actions: VolumeActions): TemplateResult {
  const { surfaces } = state;
  return html`<section class="section" aria-labelledby="surfaces-label">
    <div class="section-head">
      <h2 id="surfaces-label">${panelTexts.surfaces}</h2>
      <wa-button
        class="icon-button save-surface"
        appearance="plain"
        size="s"
        title=${panelTexts.saveSurfaceTitle}
        @click=${actions.saveSurface}
        ><span class="visually-hidden">${panelTexts.saveSurface}</span>${icon("mesh")}</wa-button
      >
      <wa-button
        class="icon-button"
        appearance="plain"
        size="s"
        title=${panelTexts.addSurface}
        ?disabled=${surfaces.length >= maxSurfaces}
        @click=${actions.addSurface}
        ><span class="visually-hidden">${panelTexts.addSurface}</span>${icon("plus")}</wa-button
      >
    </div>
    <ul class="surfaces">
      ${surfaces.map((surface, index) => surfaceRow(surface, index, state, actions))}
    </ul>
  </section>`;
}

function surfaceRow(
  surface: Surface,
  index: number,
  state: VolumeState,
  actions: VolumeActions,
): TemplateResult {
  const isActive = index === state.active;
  const number = index + 1;
  return html`<li class=${isActive ? "surface active" : "surface"}>
    <input
      type="color"
      class="swatch"
      aria-label=${panelTexts.colourOf(number)}
      .value=${surface.colour}
      @input=${(event: Event) =>
        actions.changeSurface(index, { colour: (event.target as HTMLInputElement).value })}
    />
    <button
      class="surface-value"
      type="button"
      aria-pressed=${isActive}
      title=${panelTexts.moveWithSlider}
      @click=${() => actions.activate(index)}
    >
      ${formatValue(surface.isovalue)}
    </button>
    <wa-slider
      class="opacity no-label"
      size="xs"
      label=${panelTexts.opacityOf(number)}
      title=${panelTexts.opacity}
      min="0.05"
      max="1"
      step="0.05"
      .value=${surface.opacity}
      .valueFormatter=${percent}
      @input=${(event: Event) =>
        actions.changeSurface(index, {
          opacity: Number((event.currentTarget as ValueElement).value),
        })}
    ></wa-slider>
    <span class="opacity-value">${Math.round(surface.opacity * 100)} %</span>
    <wa-button
      class="icon-button"
      appearance="plain"
      size="xs"
      title=${panelTexts.remove}
      ?disabled=${state.surfaces.length === 1}
      @click=${() => actions.removeSurface(index)}
      ><span class="visually-hidden">${panelTexts.removeSurface(number)}</span>${icon("trash")}</wa-button
    >
  </li>`;
}
