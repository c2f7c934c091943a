import { html, type TemplateResult } from "lit";
import type { StoreInfo } from "../../core/types.ts";
import { unitOf } from "../../overlay/length_unit.ts";
import { formatLength } from "../../overlay/lengths.ts";
import { pageTexts } from "../../texts/page.ts";
import { panelTexts } from "../../texts/panel.ts";
import {
  formatAxes,
  formatBytes,
  formatCount,
  formatDims,
  formatType,
  formatValue,
} from "../shell/format.ts";
import type { PageActions, VolumeState } from "./panel_state.ts";

/** Facts about the volume and its store. `actions`: if a spacing that the file lacks can be entered. */
export function volumeSection({ info }: VolumeState, actions?: PageActions): TemplateResult {
  const source = info.metadata.source ?? {};
  const type = typeof source.type === "string" ? source.type : pageTexts.bits(info.mapping.bits);
  const rows: [string, string | TemplateResult][] = [
    [
      panelTexts.voxels,
      `${formatDims(info.voxels)} (${formatCount(info.voxels.reduce((p, n) => p * n, 1))})`,
    ],
    [panelTexts.spacing, spacingPart(info, actions)],
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

/** The distances between voxels. They can be entered if the file states none. */
function spacingPart(info: StoreInfo, actions?: PageActions): string | TemplateResult {
  const lengths = info.spacing.map((mm) => formatLength(Number(mm.toPrecision(5)))).join(" × ");
  const isUnknown = unitOf(info) === "voxel";
  if (!isUnknown && !info.isSpacingGiven) return lengths;
  const text = isUnknown ? panelTexts.unknownSpacing : panelTexts.givenSpacing(lengths);
  if (!actions) return text;
  return html`${text}
    <button class="chip" type="button" @click=${actions.enterSpacing}>${isUnknown ? panelTexts.enterSpacing : panelTexts.changeSpacing}</button>`;
}
