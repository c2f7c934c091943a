import { html, nothing, svg, type TemplateResult } from "lit";
import type { Bins, FieldInfo } from "../../core/types.ts";
import { panelTexts } from "../../texts/panel.ts";
import { distinct } from "../../viewer/field_of.ts";
import type { FieldLook, FieldScale } from "../../viewer/types.ts";
import { formatValue, parseValue } from "../shell/format.ts";
import { select } from "./form_elements.ts";
import type { PictureActions } from "./panel_state.ts";
import { proposedLines } from "./proposed_lines.ts";

/** Numbers of colours to choose from. */
const steps = ["0", "4", "6", "8", "10", "12"];

/** How a field is shown: the values of the first and the last colour, the scale, the number of colours. */
export function fieldPart(
  look: FieldLook,
  field: FieldInfo,
  counts: Bins | undefined,
  actions: PictureActions,
): TemplateResult {
  const change = (part: Partial<FieldLook>) => actions.changeLook({ field: { ...look, ...part } });
  const range = look.range ?? field.range;
  const end = (label: string, at: 0 | 1) => {
    const enter = (event: Event) => {
      const input = event.currentTarget as HTMLInputElement;
      const value = parseValue(input.value);
      const [low, high] = range;
      const entered: [number, number] = at === 0 ? [value ?? low, high] : [low, value ?? high];
      if (entered[0] < entered[1]) change({ range: entered });
      else input.value = formatValue(range[at]);
    };
    return html`<label
      >${label}
      <input
        class="small-input"
        type="text"
        inputmode="decimal"
        autocomplete="off"
        .value=${formatValue(range[at])}
        @change=${enter}
      />
    </label>`;
  };
  // An address may name another number.
  const numbers = [...new Set([...steps, String(look.steps)])];
  const stepTexts = Object.fromEntries(
    numbers.map((n) => [n, n === "0" ? panelTexts.continuous : panelTexts.colourSteps(n)]),
  );
  return html`${counts ? histogram(counts, range) : nothing}
    <div class="field-range">
      ${end(panelTexts.coloursFrom, 0)} ${end(panelTexts.coloursTo, 1)}
      <button
        type="button"
        class="chip"
        title=${panelTexts.fitColoursTitle}
        @click=${() => change({ range: null })}
      >
        ${panelTexts.fitColours}
      </button>
      <button type="button" class="chip" @click=${() => change({ range: distinct(field.range) })}>
        ${panelTexts.wholeRange}
      </button>
    </div>
    ${select(panelTexts.fieldScale, look.scale, panelTexts.fieldScales, (chosen) => {
      change({ scale: chosen as FieldScale });
    })}
    ${select(panelTexts.fieldSteps, String(look.steps), stepTexts, (n) => change({ steps: Number(n) }))}
    ${linesPart(look, range, (lines) => change({ lines }))}`;
}

/** The contour lines: a switch, and their distance. */
function linesPart(
  { lines, scale }: FieldLook,
  range: readonly [number, number],
  change: (lines: number) => void,
): TemplateResult {
  const enter = (event: Event) => {
    const input = event.currentTarget as HTMLInputElement;
    const value = parseValue(input.value);
    if (value !== undefined && value > 0) change(value);
    else input.value = formatValue(lines);
  };
  return html`<div class="field-range">
    <button
      type="button"
      class="chip"
      title=${panelTexts.contourLinesTitle}
      aria-pressed=${lines > 0}
      @click=${() => change(lines > 0 ? 0 : proposedLines(range, scale))}
    >
      ${panelTexts.contourLines}
    </button>
    ${
      lines > 0
        ? html`<label
            >${scale === "logarithmic" ? panelTexts.lineDecades : panelTexts.lineInterval}
            <input
              class="small-input"
              type="text"
              inputmode="decimal"
              autocomplete="off"
              .value=${formatValue(lines)}
              @change=${enter}
            />
          </label>`
        : nothing
    }
  </div>`;
}

/** How often values occur on the surface, with the range of the colours. Heights are square roots of the counts. */
function histogram({ low, high, counts }: Bins, range: readonly [number, number]): TemplateResult {
  const most = Math.max(1, ...counts);
  const bars = counts.map((count, i) => `V${1 - Math.sqrt(count / most)}H${i + 1}`).join("");
  const placeOf = (value: number) =>
    high > low ? counts.length * Math.max(0, Math.min(1, (value - low) / (high - low))) : 0;
  const name = panelTexts.fieldHistogram(formatValue(low), formatValue(high));
  return html`<svg
    class="field-histogram"
    role="img"
    aria-label=${name}
    viewBox=${`0 0 ${counts.length} 1`}
    preserveAspectRatio="none"
  >
    <title>${name}</title>
    <path d=${`M0,1${bars}V1Z`} />
    ${range.map((end) => svg`<line x1=${placeOf(end)} x2=${placeOf(end)} y1="0" y2="1" />`)}
  </svg>`;
}
