import { html, nothing, type TemplateResult } from "lit";
import { live } from "lit/directives/live.js";
import { activeCellsAt } from "../../core/active_cells.ts";
import { panelTexts } from "../../texts/panel.ts";
import { formatValue, parseValue } from "../shell/format.ts";
import { choicesPart } from "./choices_part.ts";
import { costText } from "./isovalue_cost.ts";
import { sliderEnds } from "./isovalue_scale.ts";
import type { VolumeActions, VolumeState } from "./panel_state.ts";

/** Durations of a sweep to choose from, in seconds. */
const sweepSeconds = [5, 10, 20, 40];

/** The isovalue of the active surface: a field, the histogram with its slider, the sweep, the suggestions. */
export function isovalueSection(state: VolumeState, actions: VolumeActions): TemplateResult {
  const { scale, info } = state;
  const [least, most] = sliderEnds(scale);
  const active = state.surfaces[state.active];
  const isovalue = active?.isovalue ?? scale.low;
  const units = info.metadata.units;
  const entered = (event: Event) => {
    const field = event.currentTarget as HTMLInputElement;
    const value = parseValue(field.value);
    actions.type(undefined);
    if (value !== undefined) actions.enter(value);
  };
  const typed = (event: Event) => actions.type((event.currentTarget as HTMLInputElement).value);
  const slid = (event: Event) =>
    actions.slide((event.currentTarget as HTMLInputElement).valueAsNumber);
  const { title } = state;
  return html`<section class="section isovalue" aria-label=${panelTexts.isovalue}>
    ${title ? html`<p class="isovalue-layer quiet" title=${title}>${title}</p>` : nothing}
    <div class="section-head">
      <h2>${panelTexts.isovalue}${units ? html` <span class="quiet">${units}</span>` : nothing}</h2>
      <input
        class="isovalue-field"
        inputmode="decimal"
        autocomplete="off"
        aria-label=${panelTexts.isovalue}
        .value=${live(state.typed ?? formatValue(isovalue))}
        @input=${typed}
        @change=${entered}
        @blur=${() => actions.type(undefined)}
      />
    </div>
    <div class="histogram-box">
      ${state.histogram}
      <input
        type="range"
        class="isovalue-slider"
        aria-label=${panelTexts.isovalue}
        aria-valuetext=${units ? `${formatValue(isovalue)} ${units}` : formatValue(isovalue)}
        min=${least}
        max=${most}
        step=${scale.step}
        .valueAsNumber=${live(isovalue)}
        @input=${slid}
      />
      <div class="histogram-ends" aria-hidden="true">
        <span>${formatValue(scale.low)}</span><span>${formatValue(scale.high)}</span>
      </div>
    </div>
    <p class="isovalue-cost quiet" title=${panelTexts.costTitle}>
      ${costText(activeCellsAt(info, isovalue), state.bytes)}
    </p>
    <div class="isovalue-tools">
      <button
        type="button"
        class="chip"
        aria-pressed=${state.isSweeping}
        title=${panelTexts.sweepTitle}
        @click=${actions.toggleSweep}
      >
        ${state.isSweeping ? panelTexts.stop : panelTexts.sweep}
      </button>
      <select
        class="sweep-seconds"
        aria-label=${panelTexts.sweepDuration}
        @change=${(event: Event) =>
          actions.setSweepSeconds(Number((event.currentTarget as HTMLSelectElement).value))}
      >
        ${sweepSeconds.map(
          (seconds) =>
            html`<option value=${seconds} ?selected=${seconds === state.sweepSeconds}>${seconds} s</option>`,
        )}
      </select>
      <button
        type="button"
        class="chip"
        aria-pressed=${state.isLogarithmic}
        title=${panelTexts.logarithmicTitle}
        @click=${actions.toggleLogarithmic}
      >
        ${panelTexts.logarithmic}
      </button>
    </div>
    ${choicesPart({ ...state.offered, isovalue, colour: active?.colour ?? "", units }, actions.enter)}
  </section>`;
}
