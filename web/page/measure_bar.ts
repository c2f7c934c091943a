import { html, nothing, type TemplateResult } from "lit";
import type { MeasureTool } from "../measure/measure_tool.ts";
import { type MeasurementKind, pointCounts } from "../measure/measurement.ts";

const hints: Readonly<Record<MeasurementKind, string>> = {
  point: "Click on the surface.",
  distance: "Click two points of the surface.",
  path: "Click the points of the path, then Done.",
  angle: "Click three points: the second is the corner.",
  note: "Click where the note belongs.",
};

/** Above the picture while a tool is active: what to do, what was missed, and how to end. */
export function measureBar(tool: MeasureTool, canvas: HTMLElement): TemplateResult {
  const { kind, draft, miss } = tool;
  const canEnd = kind === "path" && draft.length >= pointCounts.path[0];
  const keys = `Enter takes the middle of the picture, ${
    kind === "path" ? "Shift + Enter is Done, " : ""
  }Escape ends.`;
  /** The button may disappear. */
  const act = (action: () => void) => () => {
    action();
    canvas.focus({ preventScroll: true });
  };
  return html`<div class="measure-bar" ?hidden=${!kind && !miss}>
    <span role="status"
      >${miss ?? (kind ? html`${hints[kind]} <span class="measure-keys">${keys}</span>` : "")}</span
    >
    ${
      canEnd
        ? html`<button type="button" class="chip" @click=${act(() => tool.finish())}>Done</button>`
        : nothing
    }
    ${
      kind
        ? html`<button
            type="button"
            class="chip"
            aria-label="End measuring"
            @click=${act(() => tool.choose(null))}
          >
            End
          </button>`
        : nothing
    }
  </div>`;
}
