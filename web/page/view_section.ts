import { html, type TemplateResult } from "lit";
import { axisNames, viewName } from "../overlay/axis_names.ts";
import type { OverlayPart } from "../overlay/parts.ts";
import { axisViews } from "../viewer/camera_views.ts";
import type { PanelActions, PanelState } from "./panel.ts";

const parts: readonly { part: OverlayPart; label: string }[] = [
  { part: "axes", label: "Axes" },
  { part: "scale", label: "Scale bar" },
  { part: "box", label: "Box" },
];

/** Views along the axes, and what lies above the picture. */
export function viewSection(
  { info, show, projection, canUndo, canRedo }: PanelState,
  actions: PanelActions,
): TemplateResult {
  const names = axisNames(info);
  return html`<wa-details class="section" appearance="plain" summary="View">
    <div class="fields">
      <div class="chips" role="group" aria-label="Views along the axes">
        ${axisViews.map((view, i) => {
          const name = names[view.axis]?.[view.side < 0 ? 0 : 1] ?? "";
          return html`<button
            type="button"
            class="chip"
            title=${`${viewName(name)} (key ${i + 1})`}
            aria-label=${viewName(name)}
            @click=${() => actions.lookAlong(view)}
          >
            ${name}
          </button>`;
        })}
        <button
          type="button"
          class="chip"
          title="Show the whole volume, without turning (key V)"
          @click=${actions.fit}
        >
          Fit
        </button>
        <button
          type="button"
          class="chip"
          title="Parallel rays: sizes do not depend on the distance (key P)"
          aria-pressed=${projection === "orthographic"}
          @click=${actions.toggleProjection}
        >
          Orthographic
        </button>
      </div>
      <div class="chips" role="group" aria-label="Changes of the view">
        <button
          type="button"
          class="chip"
          title="Take back the last change of the view (Ctrl+Z)"
          ?disabled=${!canUndo}
          @click=${actions.undo}
        >
          Undo
        </button>
        <button
          type="button"
          class="chip"
          title="Repeat what was taken back (Ctrl+Shift+Z)"
          ?disabled=${!canRedo}
          @click=${actions.redo}
        >
          Redo
        </button>
      </div>
      <div class="chips" role="group" aria-label="Picture">
        <button
          type="button"
          class="chip"
          title="Save the picture as a PNG without its background"
          @click=${actions.saveTransparent}
        >
          Save without background
        </button>
        <button
          type="button"
          class="chip"
          title="Save a picture of any size, or a film (Shift+S)"
          @click=${actions.openCapture}
        >
          Sizes and films …
        </button>
      </div>
      <div class="chips" role="group" aria-label="Above the picture">
        ${parts.map(
          ({ part, label }) => html`<button
            type="button"
            class="chip"
            aria-pressed=${show.has(part)}
            @click=${() => actions.toggleShown(part)}
          >
            ${label}
          </button>`,
        )}
      </div>
    </div>
  </wa-details>`;
}
