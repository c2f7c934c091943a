import { html, type TemplateResult } from "lit";
import { styleMap } from "lit/directives/style-map.js";
import {
  defaultLight,
  type Light,
  lightFromDisc,
  lightOnDisc,
  lightRanges,
} from "../viewer/light.ts";
import type { PanelActions, PanelState } from "./panel.ts";

type ValueElement = HTMLElement & { value: string };

const percent = (value: number) => `${Math.round(value * 100)} %`;
/** An arrow key turns the key light by this much. */
const keyDegrees = 5;

interface Slider {
  name: keyof Light;
  label: string;
  step: number;
}
const sliders: Slider[] = [
  { name: "key", label: "Key light", step: 0.05 },
  { name: "sky", label: "Light from all sides", step: 0.05 },
  { name: "rim", label: "Light from behind", step: 0.05 },
  { name: "highlight", label: "Highlights", step: 0.05 },
  { name: "roughness", label: "Roughness", step: 0.05 },
  { name: "occlusion", label: "Ambient occlusion", step: 0.05 },
  { name: "occlusionRadius", label: "Reach of occlusion", step: 0.01 },
  { name: "shadow", label: "Shadows", step: 0.05 },
  { name: "shadowSoftness", label: "Softness of shadows", step: 0.01 },
];

function directionText({ azimuth, elevation }: Light): string {
  const across = `${Math.abs(azimuth)}° from the ${azimuth < 0 ? "left" : "right"}`;
  return `${across}, ${Math.abs(elevation)}° from ${elevation < 0 ? "below" : "above"}`;
}

/** A ball as the key light shows it: dragging moves the light, as do the arrow keys. */
function ball(
  light: Light,
  change: (light: Light) => void,
  turn: PanelActions["turnLight"],
): TemplateResult {
  const { x, y } = lightOnDisc(light);
  const move = (event: PointerEvent) => {
    const box = (event.currentTarget as HTMLElement).getBoundingClientRect();
    const across = (2 * (event.clientX - box.left)) / box.width - 1;
    const up = 1 - (2 * (event.clientY - box.top)) / box.height;
    change({ ...light, ...lightFromDisc(across, up) });
  };
  const pressed = (event: PointerEvent) => {
    (event.currentTarget as HTMLElement).setPointerCapture(event.pointerId);
    move(event);
  };
  const moved = (event: PointerEvent) => {
    if ((event.currentTarget as HTMLElement).hasPointerCapture(event.pointerId)) move(event);
  };
  const keyed = (event: KeyboardEvent) => {
    const steps: Record<string, [number, number]> = {
      ArrowLeft: [-keyDegrees, 0],
      ArrowRight: [keyDegrees, 0],
      ArrowUp: [0, keyDegrees],
      ArrowDown: [0, -keyDegrees],
    };
    const step = steps[event.key];
    if (!step) return;
    event.preventDefault();
    turn(...step);
  };
  const at = { "--light-x": `${50 + 50 * x}%`, "--light-y": `${50 - 50 * y}%` };
  return html`<div class="field">
    <span class="field-label" id="light-label">Direction of the key light</span>
    <div
      class="light-ball"
      role="slider"
      tabindex="0"
      aria-labelledby="light-label"
      aria-valuemin="-180"
      aria-valuemax="180"
      aria-valuenow=${light.azimuth}
      aria-valuetext=${directionText(light)}
      title="Drag, or use the arrow keys. On the picture: hold L and drag"
      style=${styleMap(at)}
      @pointerdown=${pressed}
      @pointermove=${moved}
      @keydown=${keyed}
    ></div>
  </div>`;
}

export function lightSection(state: PanelState, actions: PanelActions): TemplateResult {
  const { look } = state;
  const { light } = look;
  const change = (to: Light) => actions.changeLook({ light: to });
  const isDefault = (Object.keys(defaultLight) as (keyof Light)[]).every(
    (name) => light[name] === defaultLight[name],
  );
  return html`<wa-details class="section" appearance="plain" summary="Light">
    <div class="fields">
      ${ball(light, change, actions.turnLight)}
      ${sliders.map(
        ({ name, label, step }) => html`<wa-slider
          size="s"
          label=${label}
          .min=${lightRanges[name][0]}
          .max=${lightRanges[name][1]}
          .step=${step}
          .value=${light[name]}
          .valueFormatter=${percent}
          @input=${(event: Event) =>
            change({ ...light, [name]: Number((event.currentTarget as ValueElement).value) })}
        ></wa-slider>`,
      )}
      <wa-slider
        size="s"
        label="Edge shading"
        min="0"
        max="1"
        step="0.05"
        .value=${look.eyeDome}
        .valueFormatter=${percent}
        @input=${(event: Event) =>
          actions.changeLook({ eyeDome: Number((event.currentTarget as ValueElement).value) })}
      ></wa-slider>
      <wa-button
        size="s"
        appearance="outlined"
        ?disabled=${isDefault}
        @click=${() => change(defaultLight)}
        >Reset the light</wa-button
      >
    </div>
  </wa-details>`;
}
