import { html, nothing, type TemplateResult } from "lit";
import { pageTexts } from "../../texts/page.ts";
import { panelTexts } from "../../texts/panel.ts";
import type { Legend, LineTick } from "../../viewer/types.ts";
import { formatValue } from "../shell/format.ts";

/** The units of a quantity; `values`: the units of the volume's values. */
function unitsOf({ colourBy }: Legend, values: string | undefined): string {
  if (colourBy === "isovalue") return values ?? "";
  if (colourBy === "gradient") return pageTexts.perLength(values ?? "");
  return colourBy === "projection-error" ? pageTexts.cells : "";
}

function bar(
  colours: readonly string[],
  low: unknown,
  high: unknown,
  ticks: readonly LineTick[] = [],
): TemplateResult {
  return html`<div
      class="legend-colours"
      style=${`background:linear-gradient(to right, ${colours.join(", ")})`}
    >
      ${ticks.map(({ at, isDark }) => html`<i class=${isDark ? "dark" : ""} style=${`left:${100 * at}%`}></i>`)}
    </div>
    <div class="legend-ends"><span>${low}</span><span>${high}</span></div>`;
}

/** The colours of slices. */
function slicesPart(
  { range: [low, high], colours }: NonNullable<Legend["ofSlices"]>,
  units: string,
): TemplateResult {
  return html`<div>
      ${panelTexts.values}${units ? html` <span class="quiet">${units}</span>` : nothing}
    </div>
    ${bar(colours, formatValue(low), formatValue(high))}`;
}

/** The name of the quantity that colours show, its units (or empty), and the texts at the ends of the colours. */
export interface LegendTexts {
  name: string;
  units: string;
  low: string;
  high: string;
}

export function legendTexts(legend: Legend, valueUnits: string | undefined): LegendTexts {
  const [low = pageTexts.near, high = pageTexts.far] = legend.range?.map(formatValue) ?? [];
  if (legend.field && legend.categories) {
    return { name: legend.field.name, units: "", low: "", high: "" };
  }
  const isOfSlices = legend.slices && legend.colourBy === "isovalue";
  const name = isOfSlices ? panelTexts.values : panelTexts.quantities[legend.colourBy];
  const { field } = legend;
  if (field) {
    const { name, units = "", scale } = field;
    const said = scale === "logarithmic" ? pageTexts.logarithmic(name) : name;
    return { name: said, units, low, high };
  }
  return { name, units: unitsOf(legend, valueUnits), low, high };
}

/** What a legend states about its field: "Lines every 50 Pa", "Grey: no value". */
export function fieldNotes({ lines, field }: Legend): string[] {
  const notes: string[] = [];
  if (lines && field) {
    const interval = formatValue(lines.interval);
    const isLogarithmic = field.scale === "logarithmic";
    notes.push(
      isLogarithmic
        ? pageTexts.linesPerDecades(interval, lines.interval === 1)
        : pageTexts.linesEvery(`${interval} ${field.units ?? ""}`.trim()),
    );
  }
  if (field?.hasMissing) notes.push(panelTexts.fieldMissing);
  return notes;
}

/** The most labels that a legend lists. */
export const mostListed = 12;

/** The texts and colours of the labels that a legend lists, and how many more there are. */
export function listedLabels({ categories = [] }: Legend): {
  labels: { text: string; colour: string }[];
  more: number;
} {
  const isLong = categories.length > mostListed;
  const labels = categories.slice(0, isLong ? mostListed - 1 : mostListed);
  return {
    labels: labels.map(({ value, name, colour }) => ({
      text: name || panelTexts.label(formatValue(value)),
      colour,
    })),
    more: categories.length - labels.length,
  };
}

function labelList(legend: Legend): TemplateResult {
  const { labels, more } = listedLabels(legend);
  return html`<ul class="legend-labels">
    ${labels.map(({ text, colour }) => html`<li><i style=${`background:${colour}`}></i>${text}</li>`)}
    ${more > 0 ? html`<li class="quiet">${panelTexts.moreLabels(String(more))}</li>` : nothing}
  </ul>`;
}

/** The colour map and the values at its ends, or the labels and their colours. */
export function legendPart(legend: Legend, valueUnits: string | undefined): TemplateResult {
  const { name, units, low, high } = legendTexts(legend, valueUnits);
  if (legend.categories) {
    return html`<figure class="legend" aria-label=${name}>
      <figcaption>${name}</figcaption>
      ${labelList(legend)}
      ${fieldNotes(legend).map((note) => html`<div class="quiet">${note}</div>`)}
      ${legend.ofSlices ? slicesPart(legend.ofSlices, valueUnits ?? "") : nothing}
      ${legend.slices ? html`<div class="legend-hatched">${panelTexts.noValues}</div>` : nothing}
    </figure>`;
  }
  return html`<figure class="legend" aria-label=${pageTexts.colours(name, low, high, units)}>
    <figcaption>${name}${units ? html` <span class="quiet">${units}</span>` : nothing}</figcaption>
    ${bar(legend.colours, low, high, legend.lines?.ticks)}
    ${fieldNotes(legend).map((note) => html`<div class="quiet">${note}</div>`)}
    ${legend.ofSlices ? slicesPart(legend.ofSlices, valueUnits ?? "") : nothing}
    ${legend.slices ? html`<div class="legend-hatched">${panelTexts.noValues}</div>` : nothing}
  </figure>`;
}
