import { formatBytes, formatCount } from "./format.ts";

/** What an isovalue costs: "about 294 k cells, 400 KB at full detail". Empty if unknown. */
export function costText(cells: number | undefined, bytes: number | undefined): string {
  const parts = [
    ...(cells === undefined ? [] : [`about ${formatCount(cells)} active cells`]),
    ...(bytes === undefined ? [] : [`${formatBytes(bytes)} at full detail`]),
  ];
  return parts.join(", ");
}
