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
import type { VolumeState } from "./panel_state.ts";

/** Facts about the volume and its store. */
export function volumeSection({ info }: VolumeState): TemplateResult {
  const source = info.metadata.source ?? {};
  const type = typeof source.type === "string" ? source.type : pageTexts.bits(info.mapping.bits);
  const rows: [string, string][] = [
    [
      panelTexts.voxels,
      `${formatDims(info.voxels)} (${formatCount(info.voxels.reduce((p, n) => p * n, 1))})`,
    ],
    [panelTexts.spacing, spacingText(info)],
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

/** The distances between voxels, in one unit: that of the first. */
function spacingText(info: StoreInfo): string {
  if (unitOf(info) === "voxel") return panelTexts.unknownSpacing;
  return info.spacing.map((mm) => formatLength(Number(mm.toPrecision(5)))).join(" × ");
}
