import { html, nothing, type TemplateResult } from "lit";
import { guard } from "lit/directives/guard.js";
import { live } from "lit/directives/live.js";
import { activeCellsAt } from "../core/active_cells.ts";
import type { OverlayPart } from "../overlay/parts.ts";
import type { StoreInfo, Triple } from "../stream/types.ts";
import type { AxisView } from "../viewer/camera_views.ts";
import { extentAlong, isWhole, wholeVolume } from "../viewer/clipping.ts";
import {
  type Clip,
  type Look,
  maxSurfaces,
  type Projection,
  type Surface,
} from "../viewer/types.ts";
import {
  formatAxes,
  formatBytes,
  formatCount,
  formatDims,
  formatType,
  formatValue,
  parseValue,
} from "./format.ts";
import { icon } from "./icons.ts";
import { costText } from "./isovalue_cost.ts";
import type { IsovalueScale } from "./isovalue_scale.ts";

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
  projection: Projection | undefined;
  canUndo: boolean;
  canRedo: boolean;
  histogram: HTMLElement;
  isLogarithmic: boolean;
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
}

type ValueElement = HTMLElement & { value: string };
type RangeElement = HTMLElement & { minValue: number; maxValue: number };

// A slider renders again if its formatter is a different function, so these are constants.
const percent = (value: number) => `${Math.round(value * 100)} %`;
const withUnits = (units: string | undefined) => (value: number) =>
  units ? `${formatValue(value)} ${units}` : formatValue(value);

/** Durations of a sweep from which to choose, in seconds. */
const sweepSeconds = [5, 10, 20, 40];

export function isovalueSection(state: PanelState, actions: PanelActions): TemplateResult {
  const { scale, info } = state;
  const isovalue = state.surfaces[state.active]?.isovalue ?? scale.low;
  const units = info.metadata.units;
  const suggestions = info.metadata.suggested_isovalues ?? [];
  const entered = (event: Event) => {
    const field = event.currentTarget as ValueElement;
    const value = parseValue(field.value);
    if (value !== undefined) actions.enter(value);
    else field.value = formatValue(isovalue);
  };
  return html`<section class="section isovalue" aria-label="Isovalue">
    <div class="section-head">
      <h2>Isovalue${units ? html` <span class="quiet">${units}</span>` : nothing}</h2>
      <wa-input
        class="isovalue-field no-label"
        size="s"
        inputmode="decimal"
        autocomplete="off"
        label="Isovalue"
        .value=${live(formatValue(isovalue))}
        @change=${entered}
      ></wa-input>
    </div>
    <div class="histogram-box">
      ${state.histogram}
      <wa-slider
        class="isovalue-slider no-label"
        size="s"
        label="Isovalue"
        .min=${scale.low}
        .max=${scale.high}
        .step=${scale.step}
        .value=${isovalue}
        .valueFormatter=${guard([units], () => withUnits(units))}
        @input=${(event: Event) => actions.slide(Number((event.currentTarget as ValueElement).value))}
      ></wa-slider>
      <div class="histogram-ends" aria-hidden="true">
        <span>${formatValue(scale.low)}</span><span>${formatValue(scale.high)}</span>
      </div>
    </div>
    <p class="isovalue-cost quiet" title="The curve has the active cells of each isovalue">
      ${costText(activeCellsAt(info, isovalue), state.bytes)}
    </p>
    <div class="isovalue-tools">
      <button
        type="button"
        class="chip"
        aria-pressed=${state.isSweeping}
        title="Move the isovalue through its range"
        @click=${actions.toggleSweep}
      >
        ${state.isSweeping ? "Stop" : "Sweep"}
      </button>
      <select
        class="sweep-seconds"
        aria-label="Duration of a sweep"
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
        title="Heights of the histogram are logarithms of counts"
        @click=${actions.toggleLogarithmic}
      >
        Logarithmic
      </button>
    </div>
    ${
      suggestions.length > 0
        ? html`<div class="chips" role="group" aria-label="Suggested isovalues">
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
      <h2 id="surfaces-label">Surfaces</h2>
      <wa-button
        class="icon-button save-surface"
        appearance="plain"
        size="s"
        title="Save the surface as triangles"
        @click=${actions.saveSurface}
        ><span class="visually-hidden">Save the surface</span>${icon("save")}</wa-button
      >
      <wa-button
        class="icon-button"
        appearance="plain"
        size="s"
        title="Add a surface"
        ?disabled=${surfaces.length >= maxSurfaces}
        @click=${actions.addSurface}
        ><span class="visually-hidden">Add a surface</span>${icon("plus")}</wa-button
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
  const name = `surface ${index + 1}`;
  return html`<li class=${isActive ? "surface active" : "surface"}>
    <input
      type="color"
      class="swatch"
      aria-label=${`Colour of ${name}`}
      .value=${surface.colour}
      @input=${(event: Event) =>
        actions.changeSurface(index, { colour: (event.target as HTMLInputElement).value })}
    />
    <button
      class="surface-value"
      type="button"
      aria-pressed=${isActive}
      title="Move this surface with the slider"
      @click=${() => actions.activate(index)}
    >
      ${formatValue(surface.isovalue)}
    </button>
    <wa-slider
      class="opacity no-label"
      size="xs"
      label=${`Opacity of ${name}`}
      title="Opacity"
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
      title="Remove"
      ?disabled=${state.surfaces.length === 1}
      @click=${() => actions.removeSurface(index)}
      ><span class="visually-hidden">Remove ${name}</span>${icon("trash")}</wa-button
    >
  </li>`;
}

interface Choice {
  value: string;
  label: string;
}

function select(
  label: string,
  value: string,
  choices: readonly Choice[],
  changed: (value: string) => void,
): TemplateResult {
  return html`<wa-select
    size="s"
    label=${label}
    .value=${value}
    @change=${(event: Event) => changed((event.currentTarget as ValueElement).value)}
  >
    ${choices.map((choice) => html`<wa-option value=${choice.value}>${choice.label}</wa-option>`)}
  </wa-select>`;
}

const kinds: Choice[] = [
  { value: "automatic", label: "Automatic" },
  { value: "quad", label: "Squares (fastest)" },
  { value: "ellipse", label: "Ellipses" },
  { value: "exact", label: "Exact surface" },
];
const shadingChoices: Choice[] = [
  { value: "smooth", label: "Smooth" },
  { value: "exact", label: "Each cell's gradient" },
];
const quantities: Choice[] = [
  { value: "isosurface", label: "One per surface" },
  { value: "isovalue", label: "Isovalue" },
  { value: "gradient", label: "Gradient" },
  { value: "depth", label: "Distance" },
  { value: "level", label: "Level of detail" },
  { value: "projection-error", label: "Projection error" },
];
const maps: Choice[] = [
  { value: "viridis", label: "Viridis" },
  { value: "magma", label: "Magma" },
  { value: "cividis", label: "Cividis" },
  { value: "turbo", label: "Turbo" },
];
const backgrounds = [
  { colour: "#ffffff", label: "White" },
  { colour: "#7d838c", label: "Grey" },
  { colour: "#000000", label: "Black" },
];

export function appearanceSection(state: PanelState, actions: PanelActions): TemplateResult {
  const { look } = state;
  const isPreset = backgrounds.some((preset) => preset.colour === look.background);
  const isCustom = !state.isThemeBackground && !isPreset;
  return html`<wa-details class="section" appearance="plain" summary="Appearance">
    <div class="fields">
      ${select("Splats", look.kind, kinds, (kind) => actions.changeLook({ kind: kind as Look["kind"] }))}
      ${select("Normals", look.shading, shadingChoices, (shading) =>
        actions.changeLook({ shading: shading as Look["shading"] }),
      )}
      ${select("Colour", look.colourBy, quantities, (by) =>
        actions.changeLook({ colourBy: by as Look["colourBy"] }),
      )}
      ${
        look.colourBy === "isosurface"
          ? nothing
          : select("Colour map", look.colourMap, maps, (map) =>
              actions.changeLook({ colourMap: map as Look["colourMap"] }),
            )
      }
      <div class="field">
        <span class="field-label" id="background-label">Background</span>
        <div class="swatches" role="group" aria-labelledby="background-label">
          <button
            type="button"
            class="chip"
            aria-pressed=${state.isThemeBackground}
            @click=${actions.followTheme}
          >
            Theme
          </button>
          ${backgrounds.map(
            (preset) => html`<button
              type="button"
              class="swatch"
              style=${`background:${preset.colour}`}
              title=${preset.label}
              aria-label=${preset.label}
              aria-pressed=${!state.isThemeBackground && preset.colour === look.background}
              @click=${() => actions.changeLook({ background: preset.colour })}
            ></button>`,
          )}
          <input
            type="color"
            class=${isCustom ? "swatch chosen" : "swatch"}
            title="Another colour"
            aria-label="Background colour"
            .value=${look.background}
            @input=${(event: Event) =>
              actions.changeLook({ background: (event.target as HTMLInputElement).value })}
          />
        </div>
      </div>
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
    summary="Clipping"
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
      ${clip.planes.map((plane, i) => {
        const [low, high] = extentAlong(plane.normal, info);
        const move = (event: Event) => {
          const share = Number((event.currentTarget as ValueElement).value);
          const offset = low + share * (high - low);
          const planes = clip.planes.map((other, j) => (i === j ? { ...other, offset } : other));
          actions.changeClip({ ...clip, planes });
        };
        return html`<wa-slider
          size="s"
          label="Plane"
          min="0"
          max="1"
          step="0.005"
          .value=${(plane.offset - low) / (high - low)}
          .valueFormatter=${percent}
          @input=${move}
        ></wa-slider>`;
      })}
      <wa-button size="s" appearance="outlined" @click=${actions.cutAcrossView}
        >Cut across the view</wa-button
      >
      <wa-button
        size="s"
        appearance="outlined"
        ?disabled=${isWhole(clip)}
        @click=${() => actions.changeClip(wholeVolume)}
        >Show the whole volume</wa-button
      >
    </div>
  </wa-details>`;
}

export function volumeSection({ info }: PanelState): TemplateResult {
  const source = info.metadata.source ?? {};
  const type = typeof source.type === "string" ? source.type : `${info.mapping.bits} bit`;
  const rows: [string, string][] = [
    [
      "Voxels",
      `${formatDims(info.voxels)} (${formatCount(info.voxels.reduce((p, n) => p * n, 1))})`,
    ],
    ["Spacing", info.spacing.map(formatValue).join(" × ")],
    ["Type", formatType(type)],
    ["Values", `${formatValue(info.range[0])} to ${formatValue(info.range[1])}`],
    ["Levels of detail", String(info.levels)],
    ["Store", `${formatBytes(info.fileBytes)} in ${formatCount(info.chunkCount)} chunks`],
    ["Content", `${info.contentId.slice(0, 12)}…`],
  ];
  if (info.mapping.maxError > 0) {
    rows.splice(4, 0, ["Stored to within", formatValue(info.mapping.maxError)]);
  }
  if (info.missingVoxels > 0) rows.splice(4, 0, ["Missing", formatCount(info.missingVoxels)]);
  const axes = formatAxes(info.direction);
  if (axes) rows.splice(2, 0, ["Axes", axes]);
  return html`<wa-details class="section" appearance="plain" summary="About this volume">
    <dl class="facts">
      ${rows.map(([name, value]) => html`<dt>${name}</dt><dd>${value}</dd>`)}
    </dl>
  </wa-details>`;
}
