import { html, nothing, type TemplateResult } from "lit";
import { live } from "lit/directives/live.js";
import type { MeasureTool } from "../measure/measure_tool.ts";
import {
  angleOf,
  lengthOf,
  longestText,
  type Measurement,
  type MeasurementKind,
  pointCounts,
  voxelOf,
} from "../measure/measurement.ts";
import { formatLength } from "../overlay/lengths.ts";
import type { StoreInfo } from "../stream/types.ts";
import { formatValue } from "./format.ts";

const tools: readonly { kind: MeasurementKind; label: string; hint: string }[] = [
  { kind: "point", label: "Point", hint: "Click on the surface." },
  { kind: "distance", label: "Distance", hint: "Click two points of the surface." },
  { kind: "path", label: "Path", hint: "Click the points of the path, then Done." },
  { kind: "angle", label: "Angle", hint: "Click three points: the second is the corner." },
  { kind: "note", label: "Note", hint: "Click where the note belongs." },
];
const labels = new Map(tools.map(({ kind, label }) => [kind, label]));

export interface MeasureActions {
  copy(): void;
  saveCsv(): void;
  saveJson(): void;
  saveSession(): void;
}

/** The number of a measurement, as it is beside it in the picture. */
export function resultOf({ kind, points, text }: Measurement): string {
  if (kind === "note") return text ?? "";
  if (kind === "point") {
    const [x, y, z] = points[0]?.position ?? [0, 0, 0];
    return text ?? [x, y, z].map(formatValue).join(", ");
  }
  const angle = angleOf(points);
  const value =
    kind !== "angle"
      ? formatLength(lengthOf(points))
      : angle === undefined
        ? "no angle"
        : `${angle.toFixed(1)}°`;
  return text ? `${text}: ${value}` : value;
}

/** What else is known of its points. */
function facts({ kind, points }: Measurement, info: StoreInfo): string {
  if (kind !== "point" && kind !== "note") {
    const isCoarse = points.some(({ level }) => level !== undefined && level > 0);
    return isCoarse ? "From coarse cells: come closer to measure exactly." : "";
  }
  const [point] = points;
  if (!point) return "";
  const voxel = voxelOf(info, point.position).map((n) => n.toFixed(2));
  const units = info.metadata.units;
  return [
    kind === "note" ? `at ${point.position.map(formatValue).join(", ")}` : "",
    `voxel ${voxel.join(", ")}`,
    point.value === undefined ? "" : `value ${formatValue(point.value)}${units ? ` ${units}` : ""}`,
    point.normal ? `normal ${point.normal.map((n) => n.toFixed(3)).join(", ")}` : "",
    point.level ? `from cells of level ${point.level}: come closer to measure exactly` : "",
  ]
    .filter((text) => text !== "")
    .join(" · ");
}

/** The section of the panel. */
export function measureSection(
  tool: MeasureTool,
  info: StoreInfo,
  actions: MeasureActions,
): TemplateResult {
  const { kind, draft, measurements, miss } = tool;
  const hint = tools.find((each) => each.kind === kind)?.hint;
  const canEnd = kind === "path" && draft.length >= pointCounts.path[0];
  return html`<div class="fields">
    <div class="chips" role="group" aria-label="Measure">
      ${tools.map(
        (each) => html`<button
          type="button"
          class="chip"
          aria-pressed=${each.kind === kind}
          @click=${() => tool.choose(each.kind)}
        >
          ${each.label}
        </button>`,
      )}
      ${
        canEnd
          ? html`<button type="button" class="chip" @click=${() => tool.finish()}>Done</button>`
          : nothing
      }
    </div>
    <p class="quiet" role="status">
      ${miss ?? (hint ? `${hint} Enter takes the middle of the picture, Escape ends.` : "")}
    </p>
    ${measurements.length > 0 ? list(tool, info) : nothing}
    <div class="chips" role="group" aria-label="Take measurements away">
      ${
        measurements.length > 0
          ? html`<button type="button" class="chip" @click=${actions.copy}>Copy</button>
              <button type="button" class="chip" @click=${actions.saveCsv}>CSV</button>
              <button type="button" class="chip" @click=${actions.saveJson}>JSON</button>
              <button type="button" class="chip" @click=${() => tool.clear()}>Remove all</button>`
          : nothing
      }
      <button
        type="button"
        class="chip"
        title="View and measurements in a file: drop it on this page to open it"
        @click=${actions.saveSession}
      >
        Save session
      </button>
    </div>
  </div>`;
}

function list(tool: MeasureTool, info: StoreInfo): TemplateResult {
  return html`<ol class="measurements" aria-label="Measurements">
    ${tool.measurements.map((measurement, i) => {
      const name = `${labels.get(measurement.kind)} ${i + 1}`;
      const more = facts(measurement, info);
      return html`<li class="measurement">
        <span class="measurement-value">
          <span class="visually-hidden">${name}:</span> ${resultOf(measurement)}
        </span>
        <button
          type="button"
          class="chip"
          aria-label=${`Remove ${name}`}
          @click=${() => tool.remove(i)}
        >
          Remove
        </button>
        ${more ? html`<span class="measurement-facts quiet">${more}</span>` : nothing}
        <input
          type="text"
          aria-label=${`Text of ${name}`}
          placeholder="Text"
          maxlength=${longestText}
          .value=${live(measurement.text ?? "")}
          @change=${(event: Event) => {
            tool.rename(i, (event.currentTarget as HTMLInputElement).value.trim());
          }}
        />
      </li>`;
    })}
  </ol>`;
}
