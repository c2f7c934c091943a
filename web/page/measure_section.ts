import { html, nothing, type TemplateResult } from "lit";
import { live } from "lit/directives/live.js";
import { repeat } from "lit/directives/repeat.js";
import type { MeasureTool } from "../measure/measure_tool.ts";
import {
  angleOf,
  lengthOf,
  longestText,
  type Measurement,
  type MeasurementKind,
  measurementKinds,
  voxelOf,
} from "../measure/measurement.ts";
import type { SurfaceExtent } from "../mesh/index.ts";
import { formatLength, formatPower } from "../overlay/lengths.ts";
import type { StoreInfo } from "../stream/types.ts";
import { formatBytes, formatValue } from "./format.ts";

const labels: Readonly<Record<MeasurementKind, string>> = {
  point: "Point",
  distance: "Distance",
  path: "Path",
  angle: "Angle",
  note: "Note",
};

/** Area and volume of an isosurface: found, or on the way. */
export interface ExtentState {
  isovalue: number;
  /** 0 … 1 while it is being computed. */
  share?: number;
  extent?: SurfaceExtent;
  problem?: string;
}

export interface MeasureActions {
  /** Removes a measurement, or all; section: whose focus is to be kept. */
  remove(index: number | "all", section: Element | null): void;
  /** Computes area and volume of the isosurfaces shown; or stops. */
  measureSurfaces(): void;
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
  {
    extents,
    problem,
    bytes,
  }: { extents: readonly ExtentState[]; problem: string; bytes: number | undefined },
  actions: MeasureActions,
): TemplateResult {
  const { kind, measurements } = tool;
  return html`<div class="fields">
    <div class="chips" role="group" aria-label="Measure">
      ${measurementKinds.map(
        (each) => html`<button
          type="button"
          class="chip"
          aria-pressed=${each === kind}
          @click=${() => tool.choose(each)}
        >
          ${labels[each]}
        </button>`,
      )}
    </div>
    ${problem ? html`<p class="measurement-facts">${problem}</p>` : nothing}
    ${measurements.length > 0 ? list(tool, info, actions) : nothing}
    <div class="chips">
      <button
        type="button"
        class="chip"
        title="Of the whole isosurface, from triangles at full detail, for which these bytes are read"
        @click=${actions.measureSurfaces}
      >
        ${
          extents.some(({ share }) => share !== undefined)
            ? "Stop"
            : html`Area and volume${
                bytes === undefined
                  ? nothing
                  : html` <span class="quiet">${formatBytes(bytes)}</span>`
              }`
        }
      </button>
    </div>
    ${extents.map(progressPart)}
    <div role="status">${extents.map(extentPart)}</div>
    <div class="chips" role="group" aria-label="Copy and save">
      ${
        measurements.length > 0
          ? html`<button type="button" class="chip" @click=${actions.copy}>Copy</button>
              <button type="button" class="chip" @click=${actions.saveCsv}>CSV</button>
              <button type="button" class="chip" @click=${actions.saveJson}>JSON</button>
              <button type="button" class="chip" @click=${(event: Event) => actions.remove("all", sectionOf(event))}>Remove all</button>`
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

/** Outside of what screen readers announce. */
function progressPart({ isovalue, share }: ExtentState): TemplateResult | typeof nothing {
  if (share === undefined) return nothing;
  const name = `Isovalue ${formatValue(isovalue)}`;
  return html`<p class="measurement-facts">
    ${name}: <progress aria-label=${name} max="1" .value=${share}></progress> ${Math.round(100 * share)} %
  </p>`;
}

function extentPart({ isovalue, extent, problem }: ExtentState) {
  const name = `Isovalue ${formatValue(isovalue)}`;
  if (problem) return html`<p class="measurement-facts">${name}: ${problem}</p>`;
  if (!extent) return nothing;
  const { area, volumeAbove, gridVolume } = extent;
  const percent = ((100 * (volumeAbove ?? 0)) / gridVolume).toPrecision(3);
  return html`<p class="measurement-facts">
    ${name}: area <b>${formatPower(area, 2)}</b>,
    ${
      volumeAbove === undefined
        ? "no volume: the surface has holes where voxels are missing"
        : html`volume of greater values <b>${formatPower(volumeAbove, 3)}</b> (${percent} %)`
    }
  </p>`;
}

/** A new text leaves the points as they are. */
function keyOf({ points }: Measurement): unknown {
  return points;
}

function sectionOf(event: Event): Element | null {
  return (event.currentTarget as Element).closest(".fields");
}

function list(tool: MeasureTool, info: StoreInfo, actions: MeasureActions): TemplateResult {
  return html`<ol class="measurements" aria-label="Measurements">
    ${repeat(tool.measurements, keyOf, (measurement, i) => {
      const name = `${labels[measurement.kind]} ${i + 1}`;
      const more = facts(measurement, info);
      return html`<li class="measurement">
        <span class="measurement-value">
          <span class="visually-hidden">${name}:</span> ${resultOf(measurement)}
        </span>
        <button
          type="button"
          class="chip"
          aria-label=${`Remove ${name}`}
          @click=${(event: Event) => actions.remove(i, sectionOf(event))}
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
