import { html, nothing, type TemplateResult } from "lit";
import type { MeasureTool } from "../../measure/measure_tool.ts";
import { pointCounts } from "../../measure/measurement.ts";
import { measureTexts } from "../../texts/measure.ts";

/**
 * The bar over the picture while a tool is active: instructions, the result of a missed click, and
 * a button to end. `announced`: for screen readers, the last measurement.
 */
export function measureBar(
  tool: MeasureTool,
  canvas: HTMLElement,
  announced: string,
): TemplateResult {
  const { kind, draft, miss } = tool;
  const canEnd = kind === "path" && draft.length >= pointCounts.path[0];
  const keys = kind === "path" ? measureTexts.pathKeys : measureTexts.keys;
  /** Runs an action; the button may disappear. */
  const act = (action: () => void) => () => {
    action();
    canvas.focus({ preventScroll: true });
  };
  return html`<span class="visually-hidden measure-announced" role="status">${announced}</span>
  <div class="measure-bar" ?hidden=${!kind && !miss}>
    <span role="status"
      >${miss ?? (kind ? html`${measureTexts.hints[kind]} <span class="measure-keys">${keys}</span>` : "")}</span
    >
    ${
      canEnd
        ? html`<button type="button" class="chip" @click=${act(() => tool.finish())}>${measureTexts.done}</button>`
        : nothing
    }
    ${
      kind
        ? html`<button
            type="button"
            class="chip"
            aria-label=${measureTexts.endMeasuring}
            @click=${act(() => tool.choose(null))}
          >
            ${measureTexts.end}
          </button>`
        : nothing
    }
  </div>`;
}
