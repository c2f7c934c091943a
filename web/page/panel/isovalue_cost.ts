import { panelTexts } from "../../texts/panel.ts";
import { formatBytes, formatCount } from "../shell/format.ts";

/** The cost of an isovalue: "about 294 k cells, 400 KB at full detail". Empty if unknown. */
export function costText(cells: number | undefined, bytes: number | undefined): string {
  const parts = [
    ...(cells === undefined ? [] : [panelTexts.activeCells(formatCount(cells))]),
    ...(bytes === undefined ? [] : [panelTexts.atFullDetail(formatBytes(bytes))]),
  ];
  return parts.join(", ");
}
