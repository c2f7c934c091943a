import { html, nothing, type TemplateResult } from "lit";
import { layersTexts } from "../../texts/layers.ts";
import type { LayerEntry } from "./layer_rows.ts";

export interface ChosenActions {
  solo(): void;
  rename(): void;
  /** Moves the layer by one row: up (−1) or down (1). */
  move(by: -1 | 1): void;
  remove(): void;
  group(name: string): void;
}

/** The buttons for the chosen layer, for visitors who use neither dragging nor keys. */
export function chosenTools(
  { group, isFirst }: LayerEntry,
  isSolo: boolean,
  actions: ChosenActions,
): TemplateResult {
  const chip = (
    text: string,
    title: string,
    action: () => void,
    { isDisabled = false, pressed }: { isDisabled?: boolean; pressed?: boolean } = {},
  ) => html`<button
    type="button"
    class="chip"
    title=${title}
    ?disabled=${isDisabled}
    aria-pressed=${pressed === undefined ? nothing : String(pressed)}
    @click=${action}
  >
    ${text}
  </button>`;
  return html`<div class="chips layer-tools" role="group" aria-label=${layersTexts.chosen}>
    ${chip(layersTexts.solo, layersTexts.soloTitle, actions.solo, { pressed: isSolo })}
    ${chip(layersTexts.rename, `${layersTexts.rename} (F2)`, actions.rename)}
    ${chip(layersTexts.up, layersTexts.upTitle, () => actions.move(-1))}
    ${chip(layersTexts.down, layersTexts.downTitle, () => actions.move(1))}
    ${chip(
      layersTexts.remove,
      isFirst ? layersTexts.firstStays : layersTexts.removeTitle,
      actions.remove,
      { isDisabled: isFirst },
    )}
    <label class="layer-group-field">
      <span class="quiet">${layersTexts.groupField}</span>
      <input
        class="small-input"
        type="text"
        maxlength="200"
        .value=${group}
        @change=${(event: Event) => actions.group((event.currentTarget as HTMLInputElement).value)}
      />
    </label>
  </div>`;
}
