import { html, nothing, type TemplateResult } from "lit";
import type { FieldInfo } from "../../core/types.ts";
import { pageTexts } from "../../texts/page.ts";
import { panelTexts } from "../../texts/panel.ts";
import type { Look } from "../../viewer/types.ts";
import { languageChoice } from "../shell/chrome.ts";
import { fieldPart } from "./field_part.ts";
import { select } from "./form_elements.ts";
import type { PictureActions, PictureState, VolumeState } from "./panel_state.ts";

/** Names that are the same in all languages. */
export const mapNames = { viridis: "Viridis", magma: "Magma", cividis: "Cividis", turbo: "Turbo" };
const backgrounds = [
  { colour: "#ffffff", name: "white" },
  { colour: "#7d838c", name: "grey" },
  { colour: "#000000", name: "black" },
] as const;

/** In the list of quantities, before the name of a field. */
const fieldPrefix = "field:";

/** The quantities that colours can show. A field that the store lacks is listed while it is chosen. */
function quantities(
  fields: readonly FieldInfo[],
  { colourBy, field }: Look,
): Record<string, string> {
  const { field: _, ...others } = panelTexts.quantities;
  const names = new Set(fields.map(({ name }) => name));
  if (colourBy === "field") names.add(field.name);
  return { ...others, ...Object.fromEntries([...names].map((name) => [fieldPrefix + name, name])) };
}

function colouredBy(chosen: string, { field }: Look): Partial<Look> {
  if (!chosen.startsWith(fieldPrefix)) return { colourBy: chosen as Look["colourBy"] };
  const name = chosen.slice(fieldPrefix.length);
  return { colourBy: "field", field: { ...field, name, range: null, lines: 0 } };
}

/** Splats, colouring and background of the picture; the language of the page. */
export function appearanceSection(
  state: PictureState & Pick<VolumeState, "info" | "fieldBins" | "hasLabels">,
  actions: PictureActions,
): TemplateResult {
  const { look } = state;
  const { fields } = state.info;
  const field = fields.find(({ name }) => name === look.field.name);
  const isPreset = backgrounds.some((preset) => preset.colour === look.background);
  const isCustom = !state.isThemeBackground && !isPreset;
  return html`<wa-details class="section" appearance="plain" summary=${panelTexts.appearance}>
    <div class="fields">
      ${select(panelTexts.splats, look.kind, panelTexts.kinds, (kind) => actions.changeLook({ kind: kind as Look["kind"] }), panelTexts.splatsHint)}
      ${select(panelTexts.normals, look.shading, panelTexts.shadings, (shading) =>
        actions.changeLook({ shading: shading as Look["shading"] }),
      )}
      ${select(
        panelTexts.colour,
        look.colourBy === "field" ? fieldPrefix + look.field.name : look.colourBy,
        quantities(fields, look),
        (by) => actions.changeLook(colouredBy(by, look)),
        look.colourBy === "field" && !field
          ? panelTexts.noSuchField(look.field.name)
          : panelTexts.quantityHints[look.colourBy],
      )}
      ${look.colourBy === "field" && field && !state.hasLabels ? fieldPart(look.field, field, state.fieldBins, actions) : nothing}
      ${
        look.colourBy === "isosurface" || state.hasLabels
          ? nothing
          : select(panelTexts.colourMap, look.colourMap, mapNames, (map) =>
              actions.changeLook({ colourMap: map as Look["colourMap"] }),
            )
      }
      <div class="field">
        <span class="field-label" id="background-label">${panelTexts.background}</span>
        <div class="swatches" role="group" aria-labelledby="background-label">
          <button
            type="button"
            class="chip"
            aria-pressed=${state.isThemeBackground}
            @click=${actions.followTheme}
          >
            ${panelTexts.theme}
          </button>
          ${backgrounds.map(
            (preset) => html`<button
              type="button"
              class="swatch"
              style=${`background:${preset.colour}`}
              title=${panelTexts[preset.name]}
              aria-label=${panelTexts[preset.name]}
              aria-pressed=${!state.isThemeBackground && preset.colour === look.background}
              @click=${() => actions.changeLook({ background: preset.colour })}
            ></button>`,
          )}
          <input
            type="color"
            class=${isCustom ? "swatch chosen" : "swatch"}
            title=${panelTexts.otherColour}
            aria-label=${panelTexts.backgroundColour}
            .value=${look.background}
            @input=${(event: Event) =>
              actions.changeLook({ background: (event.target as HTMLInputElement).value })}
          />
        </div>
      </div>
      <label class="field">
        <span class="field-label">${pageTexts.language}</span>
        ${languageChoice()}
      </label>
    </div>
  </wa-details>`;
}
