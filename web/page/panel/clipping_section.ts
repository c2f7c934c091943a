import { html, type TemplateResult } from "lit";
import { live } from "lit/directives/live.js";
import { ref } from "lit/directives/ref.js";
import type { StoreInfo, Triple } from "../../core/types.ts";
import { unitOf } from "../../overlay/length_unit.ts";
import { formatMeasured } from "../../overlay/lengths.ts";
import { panelTexts } from "../../texts/panel.ts";
import { isWhole, wholeVolume } from "../../viewer/clipping.ts";
import type { ClipPlane } from "../../viewer/types.ts";
import { percent, withValue } from "./form_elements.ts";
import type { PanelActions, PanelState } from "./panel_state.ts";
import { planeSlider } from "./plane_slider.ts";
import { axisText, volumeAxes } from "./volume_axes.ts";

type RangeElement = HTMLElement & {
  minValue: number;
  maxValue: number;
  updateComplete: Promise<unknown>;
};

type Formatter = (share: number) => string;

/** The formatters of volumes: sliders render again if their formatter is another function. */
const formatters = new WeakMap<StoreInfo, readonly Formatter[]>();

/** For each axis of the volume, the texts of positions along it, from its first voxel. */
export function placesAlong(info: StoreInfo): readonly Formatter[] {
  const known = formatters.get(info);
  if (known) return known;
  const made = info.spacing.map((spacing, axis) => {
    const size = ((info.voxels[axis] ?? 2) - 1) * spacing;
    return (share: number) => formatMeasured(share * size, spacing, unitOf(info));
  });
  formatters.set(info, made);
  return made;
}

/** Names the ends of a range in the page's language: the component's own names are English. */
async function nameThumbs(slider: Element | undefined, label: string): Promise<void> {
  if (!slider) return;
  await customElements.whenDefined("wa-slider");
  await (slider as RangeElement).updateComplete;
  const name = (id: string, text: string) =>
    slider.shadowRoot?.getElementById(id)?.setAttribute("aria-label", text);
  name("thumb-min", panelTexts.clippedFrom(label));
  name("thumb-max", panelTexts.clippedTo(label));
}

/** The clip box, the clip planes, and closed cuts. */
export function clippingSection(state: PanelState, actions: PanelActions): TemplateResult {
  const { clip, info } = state;
  const change = (axis: number) => (event: Event) => {
    const slider = event.currentTarget as RangeElement;
    // An empty box would show nothing, which looks the same as an empty surface.
    const from = Math.min(slider.minValue, 0.99);
    const to = Math.max(slider.maxValue, from + 0.01);
    const replaced = (ends: Triple, end: number) =>
      ends.map((other, i) => (i === axis ? end : other)) as Triple;
    actions.changeClip((now) => ({
      ...now,
      low: replaced(now.low, from),
      high: replaced(now.high, to),
    }));
  };
  // Ignore the same events of elements in the section.
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
      ${volumeAxes.map((_, i) =>
        withValue(
          html`<wa-slider
              range
              size="s"
              label=${axisText(i, info)}
              min="0"
              max="1"
              step="0.01"
              .minValue=${live(clip.low[i] ?? 0)}
              .maxValue=${live(clip.high[i] ?? 1)}
              .valueFormatter=${placesAlong(info)[i]}
              ${ref((slider) => nameThumbs(slider, axisText(i, info)))}
              @input=${change(i)}
            ></wa-slider>`,
          `${placesAlong(info)[i]?.(clip.low[i] ?? 0)} – ${placesAlong(info)[i]?.(clip.high[i] ?? 1)}`,
        ),
      )}
      ${clip.planes.map((plane) =>
        planeSlider(panelTexts.plane, plane, info, percent, (offset) => {
          // Another plane may have replaced it.
          const moved = (now: ClipPlane) =>
            now.normal === plane.normal ? { ...now, offset } : now;
          actions.changeClip((now) => ({ ...now, planes: now.planes.map(moved) }));
        }),
      )}
      <wa-button size="s" appearance="outlined" @click=${actions.cutAcrossView}
        >${panelTexts.cut}</wa-button
      >
      <wa-button
        size="s"
        appearance="outlined"
        ?disabled=${isWhole(clip)}
        @click=${() =>
          actions.changeClip(({ caps }) => ({ ...wholeVolume, ...(caps && { caps }) }))}
        >${panelTexts.wholeVolume}</wa-button
      >
      <div class="chips">
        <button
          type="button"
          class="chip"
          title=${panelTexts.closesCuts}
          aria-pressed=${clip.caps ?? false}
          @click=${() =>
            actions.changeClip(({ caps, ...others }) => ({
              ...others,
              ...(!caps && { caps: true }),
            }))}
        >
          ${panelTexts.closeCuts}
        </button>
      </div>
    </div>
  </wa-details>`;
}
