import { html, nothing, type TemplateResult } from "lit";
import { live } from "lit/directives/live.js";
import { activeCellsAt } from "../../core/active_cells.ts";
import type { OverlayPart } from "../../overlay/parts.ts";
import type { StoreInfo, Triple } from "../../stream/types.ts";
import { pageTexts } from "../../texts/page.ts";
import { panelTexts } from "../../texts/panel.ts";
import type { AxisView } from "../../viewer/camera_views.ts";
import { isWhole, wholeVolume } from "../../viewer/clipping.ts";
import {
  type Clip,
  type Look,
  maxSurfaces,
  type Projection,
  type Slices,
  type Surface,
} from "../../viewer/types.ts";
import { languageChoice } from "../shell/chrome.ts";
import {
  formatAxes,
  formatBytes,
  formatCount,
  formatDims,
  formatType,
  formatValue,
  parseValue,
} from "../shell/format.ts";
import { icon } from "../shell/icons.ts";
import { costText } from "./isovalue_cost.ts";
import { type IsovalueScale, sliderEnds } from "./isovalue_scale.ts";
import { planeSlider } from "./plane_slider.ts";

export interface PanelState {
  info: StoreInfo;
  scale: IsovalueScale;
  surfaces: readonly Surface[];
  /** Index of the surface that the slider changes. */
  active: number;
  look: Look;
  /** The background colour follows the theme. */
  isThemeBackground: boolean;
  clip: Clip;
  show: ReadonlySet<OverlayPart>;
  slices: Slices;
  projection: Projection | undefined;
  canUndo: boolean;
  canRedo: boolean;
  histogram: HTMLElement;
  isLogarithmic: boolean;
  /** What the visitor is typing into the field of the isovalue, until it is entered or left. */
  typed: string | undefined;
  isSweeping: boolean;
  sweepSeconds: number;
  /** Of the active surface's isovalue, at the finest level; undefined if it is not known. */
  bytes: number | undefined;
}

export interface PanelActions {
  /** From the slider: rounded to the scale. */
  slide(value: number): void;
  /** From the number field: not rounded, limited to the range. */
  enter(value: number): void;
  toggleLogarithmic(): void;
  /** Starts or stops to move the isovalue through its range. */
  toggleSweep(): void;
  /** Stops a sweep. The field shows this text, whatever else changes; undefined: the isovalue. */
  type(text: string | undefined): void;
  setSweepSeconds(seconds: number): void;
  activate(index: number): void;
  changeSurface(index: number, change: Partial<Surface>): void;
  addSurface(): void;
  /** Offers the active surface as a file of triangles. */
  saveSurface(): void;
  removeSurface(index: number): void;
  changeLook(change: Partial<Look>): void;
  /** Turns the key light from where it is now, which may not be shown yet. */
  turnLight(rightDegrees: number, upDegrees: number): void;
  followTheme(): void;
  /** Shows or hides what lies above the picture. */
  toggleShown(part: OverlayPart): void;
  /** Turns to a view along an axis. */
  lookAlong(view: AxisView): void;
  /** Moves so that the whole volume is seen, without turning. */
  fit(): void;
  /** Saves the picture without its background. */
  saveTransparent(): void;
  openCapture(): void;
  /** Take back, or repeat, the last change of the view. */
  undo(): void;
  redo(): void;
  /** Between perspective and orthographic. */
  toggleProjection(): void;
  changeClip(clip: Clip): void;
  /** Replaces the clip plane by one across the view. */
  cutAcrossView(): void;
  /** Whether the faces of the clip box have handles in the picture. */
  showClipHandles(isShown: boolean): void;
  changeSlices(slices: Slices): void;
  /** Replaces the oblique slice by one across the view. */
  sliceAcrossView(): void;
}

type ValueElement = HTMLElement & { value: string };
type RangeElement = HTMLElement & { minValue: number; maxValue: number };

// A slider renders again if its formatter is a different function, so this is a constant.
const percent = (value: number) => `${Math.round(value * 100)} %`;

/** Durations of a sweep from which to choose, in seconds. */
const sweepSeconds = [5, 10, 20, 40];

export function isovalueSection(state: PanelState, actions: PanelActions): TemplateResult {
  const { scale, info } = state;
  const [least, most] = sliderEnds(scale);
  const isovalue = state.surfaces[state.active]?.isovalue ?? scale.low;
  const units = info.metadata.units;
  const suggestions = info.metadata.suggested_isovalues ?? [];
  const entered = (event: Event) => {
    const field = event.currentTarget as HTMLInputElement;
    const value = parseValue(field.value);
    actions.type(undefined);
    if (value !== undefined) actions.enter(value);
  };
  const typed = (event: Event) => actions.type((event.currentTarget as HTMLInputElement).value);
  const slid = (event: Event) =>
    actions.slide((event.currentTarget as HTMLInputElement).valueAsNumber);
  return html`<section class="section isovalue" aria-label=${panelTexts.isovalue}>
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
    ${
      suggestions.length > 0
        ? html`<div class="chips" role="group" aria-label=${panelTexts.suggested}>
            ${suggestions.slice(0, 6).map(
              (value) => html`<button
                class="chip"
                type="button"
                aria-pressed=${value === isovalue}
                @click=${() => actions.enter(value)}
              >
                ${formatValue(value)}
              </button>`,
            )}
          </div>`
        : nothing
    }
  </section>`;
}

export function surfacesSection(state: PanelState, actions: PanelActions): TemplateResult {
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
        ><span class="visually-hidden">${panelTexts.saveSurface}</span>${icon("save")}</wa-button
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
  state: PanelState,
  actions: PanelActions,
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

/** choices: the label of each value. */
function select(
  label: string,
  value: string,
  choices: Readonly<Record<string, string>>,
  changed: (value: string) => void,
): TemplateResult {
  return html`<wa-select
    size="s"
    label=${label}
    .value=${value}
    @change=${(event: Event) => changed((event.currentTarget as ValueElement).value)}
  >
    ${Object.entries(choices).map(([value, label]) => html`<wa-option value=${value}>${label}</wa-option>`)}
  </wa-select>`;
}

/** The names that are the same in all languages. */
const maps = { viridis: "Viridis", magma: "Magma", cividis: "Cividis", turbo: "Turbo" };
const backgrounds = [
  { colour: "#ffffff", name: "white" },
  { colour: "#7d838c", name: "grey" },
  { colour: "#000000", name: "black" },
] as const;

export function appearanceSection(state: PanelState, actions: PanelActions): TemplateResult {
  const { look } = state;
  const isPreset = backgrounds.some((preset) => preset.colour === look.background);
  const isCustom = !state.isThemeBackground && !isPreset;
  return html`<wa-details class="section" appearance="plain" summary=${panelTexts.appearance}>
    <div class="fields">
      ${select(panelTexts.splats, look.kind, panelTexts.kinds, (kind) => actions.changeLook({ kind: kind as Look["kind"] }))}
      ${select(panelTexts.normals, look.shading, panelTexts.shadings, (shading) =>
        actions.changeLook({ shading: shading as Look["shading"] }),
      )}
      ${select(panelTexts.colour, look.colourBy, panelTexts.quantities, (by) =>
        actions.changeLook({ colourBy: by as Look["colourBy"] }),
      )}
      ${
        look.colourBy === "isosurface"
          ? nothing
          : select(panelTexts.colourMap, look.colourMap, maps, (map) =>
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

export function clippingSection(state: PanelState, actions: PanelActions): TemplateResult {
  const { clip, info } = state;
  const change = (axis: number) => (event: Event) => {
    const slider = event.currentTarget as RangeElement;
    const low = [...clip.low] as Triple;
    const high = [...clip.high] as Triple;
    // An empty box would show nothing, which looks the same as an empty surface.
    low[axis] = Math.min(slider.minValue, 0.99);
    high[axis] = Math.max(slider.maxValue, (low[axis] ?? 0) + 0.01);
    actions.changeClip({ ...clip, low, high });
  };
  // Elements in the section send the same events.
  const shown = (isShown: boolean) => (event: Event) => {
    if (event.target === event.currentTarget) actions.showClipHandles(isShown);
  };
  return html`<wa-details
    class="section"
    appearance="plain"
    summary=${panelTexts.clipping}
    @wa-show=${shown(true)}
    @wa-hide=${shown(false)}
  >
    <div class="fields">
      ${["x", "y", "z"].map(
        (axis, i) => html`<wa-slider
          range
          size="s"
          label=${axis}
          min="0"
          max="1"
          step="0.01"
          .minValue=${clip.low[i] ?? 0}
          .maxValue=${clip.high[i] ?? 1}
          .valueFormatter=${percent}
          @input=${change(i)}
        ></wa-slider>`,
      )}
      ${clip.planes.map((plane, i) =>
        planeSlider(panelTexts.plane, plane, info, percent, (offset) => {
          const planes = clip.planes.map((other, j) => (i === j ? { ...other, offset } : other));
          actions.changeClip({ ...clip, planes });
        }),
      )}
      <wa-button size="s" appearance="outlined" @click=${actions.cutAcrossView}
        >${panelTexts.cut}</wa-button
      >
      <wa-button
        size="s"
        appearance="outlined"
        ?disabled=${isWhole(clip)}
        @click=${() => actions.changeClip({ ...wholeVolume, ...(clip.caps && { caps: true }) })}
        >${panelTexts.wholeVolume}</wa-button
      >
      <div class="chips">
        <button
          type="button"
          class="chip"
          title=${panelTexts.closesCuts}
          aria-pressed=${clip.caps ?? false}
          @click=${() => {
            const { caps, ...others } = clip;
            actions.changeClip({ ...others, ...(!caps && { caps: true }) });
          }}
        >
          ${panelTexts.closeCuts}
        </button>
      </div>
    </div>
  </wa-details>`;
}

export function volumeSection({ info }: PanelState): TemplateResult {
  const source = info.metadata.source ?? {};
  const type = typeof source.type === "string" ? source.type : pageTexts.bits(info.mapping.bits);
  const rows: [string, string][] = [
    [
      panelTexts.voxels,
      `${formatDims(info.voxels)} (${formatCount(info.voxels.reduce((p, n) => p * n, 1))})`,
    ],
    [panelTexts.spacing, info.spacing.map(formatValue).join(" × ")],
    [panelTexts.type, formatType(type)],
    [panelTexts.values, pageTexts.to(formatValue(info.range[0]), formatValue(info.range[1]))],
    [panelTexts.levels, String(info.levels)],
    [
      panelTexts.store,
      panelTexts.inChunks(formatBytes(info.fileBytes), formatCount(info.chunkCount)),
    ],
    [panelTexts.content, `${info.contentId.slice(0, 12)}…`],
  ];
  if (info.mapping.maxError > 0) {
    rows.splice(4, 0, [panelTexts.storedWithin, formatValue(info.mapping.maxError)]);
  }
  if (info.missingVoxels > 0)
    rows.splice(4, 0, [panelTexts.missing, formatCount(info.missingVoxels)]);
  const axes = formatAxes(info.direction);
  if (axes) rows.splice(2, 0, [panelTexts.axes, axes]);
  return html`<wa-details class="section" appearance="plain" summary=${panelTexts.about}>
    <dl class="facts">
      ${rows.map(([name, value]) => html`<dt>${name}</dt><dd>${value}</dd>`)}
    </dl>
  </wa-details>`;
}
