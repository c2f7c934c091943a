import { html, type TemplateResult } from "lit";
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

type RangeElement = HTMLElement & { minValue: number; maxValue: number };

/** A position along the volume's axis, from its first voxel. */
function place(share: number, index: number, info: StoreInfo): string {
  const { voxels, spacing } = info;
  const size = ((voxels[index] ?? 2) - 1) * (spacing[index] ?? 1);
  return formatMeasured(share * size, spacing[index] ?? 1, unitOf(info));
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
              .minValue=${clip.low[i] ?? 0}
              .maxValue=${clip.high[i] ?? 1}
              .valueFormatter=${percent}
              @input=${change(i)}
            ></wa-slider>`,
          `${place(clip.low[i] ?? 0, i, info)} – ${place(clip.high[i] ?? 1, i, info)}`,
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
