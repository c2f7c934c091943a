import { html, nothing, type TemplateResult } from "lit";
import type { Legend } from "../viewer/types.ts";
import { formatValue } from "./format.ts";

const names: Record<Legend["colourBy"], string> = {
  isovalue: "Isovalue",
  gradient: "Gradient",
  depth: "Distance",
  level: "Level of detail",
  "projection-error": "Projection error",
};

/** The units of a quantity; `values`: the units of the volume's values. */
function unitsOf({ colourBy }: Legend, values: string | undefined): string {
  if (colourBy === "isovalue") return values ?? "";
  if (colourBy === "gradient") return values ? `${values} per unit length` : "per unit length";
  return colourBy === "projection-error" ? "cells" : "";
}

/** The colour map and the values at its ends. */
export function legendPart(legend: Legend, valueUnits: string | undefined): TemplateResult {
  const [low, high] = legend.range?.map(formatValue) ?? ["near", "far"];
  const units = unitsOf(legend, valueUnits);
  const name = names[legend.colourBy];
  return html`<figure class="legend" aria-label=${`Colours: ${name}, ${low} to ${high} ${units}`}>
    <figcaption>${name}${units ? html` <span class="quiet">${units}</span>` : nothing}</figcaption>
    <div
      class="legend-colours"
      style=${`background:linear-gradient(to right, ${legend.colours.join(", ")})`}
    ></div>
    <div class="legend-ends"><span>${low}</span><span>${high}</span></div>
  </figure>`;
}
