import { html, type TemplateResult } from "lit";
import { axisNames, viewName } from "../../overlay/axis_names.ts";
import { overlayParts } from "../../overlay/parts.ts";
import { panelTexts } from "../../texts/panel.ts";
import { axisViews } from "../../viewer/camera_views.ts";
import type { PanelActions, PanelState } from "./panel_state.ts";

/** Views along the axes, and the overlays above the picture. */
export function viewSection(
  { info, show, projection, canUndo, canRedo }: PanelState,
  actions: PanelActions,
): TemplateResult {
  const names = axisNames(info);
  return html`<wa-details class="section" appearance="plain" summary=${panelTexts.view}>
    <div class="fields">
      <div class="chips" role="group" aria-label=${panelTexts.alongAxes}>
        ${axisViews.map((view, i) => {
          const name = names[view.axis]?.[view.side < 0 ? 0 : 1] ?? "";
          return html`<button
            type="button"
            class="chip"
            title=${panelTexts.withKey(viewName(name), i + 1)}
            aria-label=${viewName(name)}
            @click=${() => actions.lookAlong(view)}
          >
            ${name}
          </button>`;
        })}
        <button
          type="button"
          class="chip"
          title=${panelTexts.fitTitle}
          @click=${actions.fit}
        >
          ${panelTexts.fit}
        </button>
        <button
          type="button"
          class="chip"
          title=${panelTexts.orthographicTitle}
          aria-pressed=${projection === "orthographic"}
          @click=${actions.toggleProjection}
        >
          ${panelTexts.orthographic}
        </button>
      </div>
      <div class="chips" role="group" aria-label=${panelTexts.changes}>
        <button
          type="button"
          class="chip"
          title=${panelTexts.undoTitle}
          ?disabled=${!canUndo}
          @click=${actions.undo}
        >
          ${panelTexts.undo}
        </button>
        <button
          type="button"
          class="chip"
          title=${panelTexts.redoTitle}
          ?disabled=${!canRedo}
          @click=${actions.redo}
        >
          ${panelTexts.redo}
        </button>
      </div>
      <div class="chips" role="group" aria-label=${panelTexts.picture}>
        <button
          type="button"
          class="chip"
          title=${panelTexts.saveTransparentTitle}
          @click=${actions.saveTransparent}
        >
          ${panelTexts.saveTransparent}
        </button>
        <button
          type="button"
          class="chip"
          title=${panelTexts.captureTitle}
          @click=${actions.openCapture}
        >
          ${panelTexts.capture}
        </button>
      </div>
      <div class="chips" role="group" aria-label=${panelTexts.above}>
        ${overlayParts.map(
          (part) => html`<button
            type="button"
            class="chip"
            aria-pressed=${show.has(part)}
            @click=${() => actions.toggleShown(part)}
          >
            ${panelTexts.parts[part]}
          </button>`,
        )}
      </div>
    </div>
  </wa-details>`;
}
