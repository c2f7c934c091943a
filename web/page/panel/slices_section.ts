import "./slices.css";
import { html, nothing, type TemplateResult } from "lit";
import { unitOf } from "../../overlay/length_unit.ts";
import { formatLength } from "../../overlay/lengths.ts";
import { localized } from "../../texts/numbers.ts";
import { slicesTexts } from "../../texts/slices.ts";
import { extentAlong } from "../../viewer/clipping.ts";
import { greyRange } from "../../viewer/grey_range.ts";
import { hasSlices } from "../../viewer/slices.ts";
import type { ColourMap, Slices } from "../../viewer/types.ts";
import { formatValue, parseValue } from "../shell/format.ts";
import { mapNames } from "./appearance_section.ts";
import { select, type ValueElement } from "./form_elements.ts";
import type { PanelActions, PanelState } from "./panel_state.ts";
import { planeSlider } from "./plane_slider.ts";
import { axisText, sidesOf, volumeAxes } from "./volume_axes.ts";

/** The section of slices: one across each axis, and an oblique one. */
export function slicesSection(state: PanelState, actions: PanelActions): TemplateResult {
  return html`<div class="fields slices">
    ${volumeAxes.map((_, axis) => axisPart(axis, state, actions))} ${obliquePart(state, actions)}
    ${hasSlices(state.slices) && state.look.colourBy !== "isovalue" ? rangePart(state, actions) : nothing}
    <p class="quiet">${slicesTexts.about}</p>
  </div>`;
}

/** A slice across an axis, with steps of one voxel. */
function axisPart(axis: number, { slices, info }: PanelState, actions: PanelActions) {
  const name = axisText(axis, info);
  const last = (info.voxels[axis] ?? 2) - 1;
  const share = slices.along[axis] ?? null;
  const voxelText = (at: number) => localized(String(Number(at.toFixed(3))));
  const voxel = Number(((share ?? 0.5) * last).toFixed(3));
  const change = (moved: (share: number | null) => number | null) =>
    actions.changeSlices((now) => {
      const along = now.along.map((other, i) => (i === axis ? moved(other) : other));
      return { ...now, along: along as unknown as Slices["along"] };
    });
  const showVoxel = (to: number) => change(() => Math.max(0, Math.min(1, to / last)));
  const toggle = () => change((share) => (share === null ? Math.round(last / 2) / last : null));
  const entered = (event: Event) => {
    const field = event.currentTarget as HTMLInputElement;
    const value = parseValue(field.value);
    const to = value === undefined ? voxel : Math.max(0, Math.min(last, value));
    field.value = voxelText(to);
    if (value !== undefined) showVoxel(to);
  };
  const isShown = share !== null;
  return html`<div class="slice" role="group" aria-label=${slicesTexts.across(name)}>
    <button
      type="button"
      class="chip"
      title=${slicesTexts.across(name)}
      aria-label=${slicesTexts.across(name)}
      aria-pressed=${isShown}
      @click=${toggle}
    >
      ${sidesOf(axis, info) ?? name}
    </button>
    ${
      isShown
        ? html`<wa-slider
              class="no-label"
              size="s"
              label=${slicesTexts.across(name)}
              min="0"
              .max=${last}
              step="1"
              .value=${voxel}
              .valueFormatter=${(at: number) =>
                slicesTexts.at(
                  localized(String(at)),
                  formatLength(at * (info.spacing[axis] ?? 1), unitOf(info)),
                )}
              @input=${(event: Event) =>
                showVoxel(Number((event.currentTarget as ValueElement).value))}
            ></wa-slider>
            <input
              class="small-input"
              type="text"
              inputmode="decimal"
              autocomplete="off"
              aria-label=${slicesTexts.voxelOf(name)}
              title=${slicesTexts.voxelOf(name)}
              .value=${voxelText(voxel)}
              @change=${entered}
            />
            <span class="slice-place quiet"
              >${formatLength(Number((voxel * (info.spacing[axis] ?? 1)).toPrecision(5)), unitOf(info))}</span
            >`
        : nothing
    }
  </div>`;
}

function obliquePart({ slices, info }: PanelState, actions: PanelActions) {
  const { plane } = slices;
  const across = html`<wa-button
    size="s"
    appearance="outlined"
    title=${slicesTexts.acrossViewTitle}
    @click=${actions.sliceAcrossView}
    >${slicesTexts.acrossView}</wa-button
  >`;
  if (!plane) return across;
  const { normal } = plane;
  const size = Math.hypot(...normal);
  const [low, high] = extentAlong(normal, info);
  const middle = (low + high) / 2;
  const positionText = (share: number) =>
    slicesTexts.fromCentre(
      formatLength(
        Number(((low + share * (high - low) - middle) / size).toPrecision(4)),
        unitOf(info),
      ),
    );
  const move = (offset: number) =>
    actions.changeSlices((now) =>
      // Another plane may have replaced it.
      now.plane?.normal === normal ? { ...now, plane: { normal, offset } } : now,
    );
  return html`${planeSlider(slicesTexts.oblique, plane, info, positionText, move)}
    ${across}
    <wa-button size="s" appearance="outlined" @click=${() => actions.changeSlices(({ plane: _, ...others }) => others)}
      >${slicesTexts.removeOblique}</wa-button
    >`;
}

/**
 * The colours of the values, and the values of the first and the last colour. Entered values are kept in
 * ascending order.
 */
function rangePart({ slices, info, look }: PanelState, actions: PanelActions) {
  const { range, mapped } = slices;
  const colours = { grey: slicesTexts.grey, ...mapNames };
  const colour = (name: string) => {
    const isMapped = name !== "grey";
    if (isMapped) actions.changeLook({ colourMap: name as ColourMap });
    actions.changeSlices(({ mapped: _, ...now }) => ({
      ...now,
      ...(isMapped && { mapped: true }),
    }));
  };
  const field = (label: string, end: 0 | 1) => {
    const value = (range ?? greyRange(info))[end];
    const enter = (event: Event) => {
      const input = event.currentTarget as HTMLInputElement;
      const to = parseValue(input.value);
      let kept = value;
      actions.changeSlices((now) => {
        const [low, high] = now.range ?? greyRange(info);
        const entered: [number, number] = end === 0 ? [to ?? low, high] : [low, to ?? high];
        const isInOrder = entered[0] < entered[1];
        kept = isInOrder ? entered[end] : ([low, high][end] ?? value);
        return isInOrder && to !== undefined ? { ...now, range: entered } : now;
      });
      input.value = formatValue(kept);
    };
    return html`<label
      >${label}
      <input
        class="small-input"
        type="text"
        inputmode="decimal"
        autocomplete="off"
        .value=${formatValue(value)}
        @change=${enter}
      />
    </label>`;
  };
  return html`${select(slicesTexts.colours, mapped ? look.colourMap : "grey", colours, colour)}
  <div class="slice slice-range">
    ${field(mapped ? slicesTexts.lowest : slicesTexts.black, 0)}
    ${field(mapped ? slicesTexts.highest : slicesTexts.white, 1)}
    ${
      range
        ? html`<button type="button" class="chip" @click=${() => actions.changeSlices(({ range: _, ...others }) => others)}>
            ${slicesTexts.wholeRange}
          </button>`
        : nothing
    }
  </div>`;
}
