import { html, type TemplateResult } from "lit";
import { styleMap } from "lit/directives/style-map.js";
import { localized } from "../../texts/numbers.ts";
import { panelTexts } from "../../texts/panel.ts";
import {
  defaultLight,
  type Light,
  lightFromDisc,
  lightOnDisc,
  lightRanges,
} from "../../viewer/light.ts";
import { lightNames, lightSettings } from "../../viewer/light_settings.ts";
import { percent, type ValueElement, withValue } from "./form_elements.ts";
import type { PictureActions, PictureState } from "./panel_state.ts";

type Strength = Exclude<keyof Light, "azimuth" | "elevation">;

/** The settings with sliders; the ball sets the others. */
const sliders = lightNames.filter(
  (name): name is Strength => name !== "azimuth" && name !== "elevation",
);

function directionText({ azimuth, elevation }: Light): string {
  const degrees = (angle: number) => localized(String(Math.abs(angle)));
  return panelTexts.lightAt(degrees(azimuth), azimuth < 0, degrees(elevation), elevation < 0);
}

/** A ball lit by the key light. Dragging it moves the light; so do the arrow keys. */
function ball(
  light: Light,
  change: PictureActions["changeLight"],
  turn: PictureActions["turnLight"],
): TemplateResult {
  const { x, y } = lightOnDisc(light);
  const move = (event: PointerEvent) => {
    const box = (event.currentTarget as HTMLElement).getBoundingClientRect();
    const across = (2 * (event.clientX - box.left)) / box.width - 1;
    const up = 1 - (2 * (event.clientY - box.top)) / box.height;
    change(lightFromDisc(across, up));
  };
  const pressed = (event: PointerEvent) => {
    (event.currentTarget as HTMLElement).setPointerCapture(event.pointerId);
    move(event);
  };
  const moved = (event: PointerEvent) => {
    if ((event.currentTarget as HTMLElement).hasPointerCapture(event.pointerId)) move(event);
  };
  const keyed = (event: KeyboardEvent) => {
    const { azimuth, elevation } = lightSettings;
    const steps: Record<string, [number, number]> = {
      ArrowLeft: [-azimuth.step, 0],
      ArrowRight: [azimuth.step, 0],
      ArrowUp: [0, elevation.step],
      ArrowDown: [0, -elevation.step],
    };
    const step = steps[event.key];
    if (!step) return;
    event.preventDefault();
    turn(...step);
  };
  const at = { "--light-x": `${50 + 50 * x}%`, "--light-y": `${50 - 50 * y}%` };
  return html`<div class="field">
    <span class="field-label" id="light-label">${panelTexts.lightDirection}</span>
    <div
      class="light-ball"
      role="slider"
      tabindex="0"
      aria-labelledby="light-label"
      aria-valuemin="-180"
      aria-valuemax="180"
      aria-valuenow=${light.azimuth}
      aria-valuetext=${directionText(light)}
      title=${panelTexts.lightHint}
      style=${styleMap(at)}
      @pointerdown=${pressed}
      @pointermove=${moved}
      @keydown=${keyed}
    ></div>
  </div>`;
}

export function lightSection(state: PictureState, actions: PictureActions): TemplateResult {
  const { look } = state;
  const { light } = look;
  const isDefault = lightNames.every((name) => light[name] === defaultLight[name]);
  return html`<wa-details class="section" appearance="plain" summary=${panelTexts.light}>
    <div class="fields">
      ${ball(light, actions.changeLight, actions.turnLight)}
      ${sliders.map((name) =>
        withValue(
          html`<wa-slider
              size="s"
              label=${panelTexts.lights[name]}
              .min=${lightRanges[name][0]}
              .max=${lightRanges[name][1]}
              .step=${lightSettings[name].step}
              .value=${light[name]}
              .valueFormatter=${percent}
              @input=${(event: Event) =>
                actions.changeLight({
                  [name]: Number((event.currentTarget as ValueElement).value),
                })}
            ></wa-slider>`,
          percent(light[name]),
        ),
      )}
      ${withValue(
        html`<wa-slider
          size="s"
          label=${panelTexts.edgeShading}
          min="0"
          max="1"
          step="0.05"
          .value=${look.eyeDome}
          .valueFormatter=${percent}
          @input=${(event: Event) =>
            actions.changeLook({ eyeDome: Number((event.currentTarget as ValueElement).value) })}
        ></wa-slider>`,
        percent(look.eyeDome),
      )}
      <wa-button
        size="s"
        appearance="outlined"
        ?disabled=${isDefault}
        @click=${() => actions.changeLook({ light: defaultLight })}
        >${panelTexts.resetLight}</wa-button
      >
    </div>
  </wa-details>`;
}
