import { html, nothing, type TemplateResult } from "lit";
import { repeat } from "lit/directives/repeat.js";
import type { StoreInfo, Triple } from "../../core/types.ts";
import type { MeasureTool } from "../../measure/measure_tool.ts";
import {
  angleOf,
  lengthOf,
  longestText,
  type Measurement,
  measurementKinds,
  voxelOf,
} from "../../measure/measurement.ts";
import type { SurfaceExtent } from "../../mesh/surface_extent.ts";
import type { LengthUnit } from "../../overlay/length_unit.ts";
import { formatMeasured, formatPower, roundedToVoxel } from "../../overlay/lengths.ts";
import { measureTexts } from "../../texts/measure.ts";
import { listed, localized } from "../../texts/numbers.ts";
import { formatBytes, formatField, formatValue } from "../shell/format.ts";

/** Area and volume of an isosurface: computed, or in progress. */
export interface ExtentState {
  isovalue: number;
  /** 0 … 1 while it is being computed. */
  share?: number;
  extent?: SurfaceExtent;
  problem?: string;
}

/** How lengths are shown. */
export interface LengthScale {
  /** The smallest edge of a voxel, in `unit`. */
  voxelMm: number;
  unit: LengthUnit;
}

export interface MeasureActions {
  /** Removes a measurement, or all; section: the element that must keep the focus. */
  remove(index: number | "all", section: Element | null): void;
  /** Starts or stops computing area and volume of the isosurfaces that are shown. */
  measureSurfaces(): void;
  copy(): void;
  saveCsv(): void;
  saveJson(): void;
  saveSession(): void;
}

/** World coordinates, rounded to what the voxels allow. */
function positionText(position: Triple, { voxelMm }: LengthScale): string {
  return listed(position.map((n) => formatValue(roundedToVoxel(n, voxelMm))));
}

/** The result of a measurement, in the form shown in the picture. */
export function resultOf({ kind, points, text }: Measurement, scale: LengthScale): string {
  if (kind === "note") return text ?? "";
  if (kind === "point") {
    return text ?? positionText(points[0]?.position ?? [0, 0, 0], scale);
  }
  const angle = angleOf(points);
  const value =
    kind !== "angle"
      ? formatMeasured(lengthOf(points), scale.voxelMm, scale.unit)
      : angle === undefined
        ? measureTexts.noAngle
        : localized(`${angle.toFixed(1)}°`);
  return text ? `${text}: ${value}` : value;
}

/** The other known properties of its points. */
function facts({ kind, points }: Measurement, info: StoreInfo, scale: LengthScale): string {
  if (kind !== "point" && kind !== "note") {
    const isCoarse = points.some(({ level }) => level !== undefined && level > 0);
    const layers = [...new Set(points.flatMap(({ layer }) => layer ?? []))];
    return [
      layers.length > 0 ? measureTexts.onLayers(layers.join(", ")) : "",
      isCoarse ? measureTexts.coarse : "",
    ]
      .filter((text) => text !== "")
      .join(" · ");
  }
  const [point] = points;
  if (!point) return "";
  const ofVoxel = point.voxel ?? voxelOf(info, point.position);
  const voxel = listed(ofVoxel.map((n) => localized(n.toFixed(2))));
  // The units are those of the page's volume.
  const units = point.layer === undefined ? info.metadata.units : undefined;
  return [
    point.layer === undefined ? "" : measureTexts.onLayers(point.layer),
    kind === "note" ? measureTexts.at(positionText(point.position, scale)) : "",
    measureTexts.voxel(voxel),
    point.value === undefined
      ? ""
      : measureTexts.value(`${formatValue(point.value)}${units ? ` ${units}` : ""}`),
    point.field ? formatField(point.field) : "",
    point.normal
      ? measureTexts.normal(listed(point.normal.map((n) => localized(n.toFixed(3)))))
      : "",
    point.level ? measureTexts.ofLevel(point.level) : "",
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
    scale,
  }: {
    extents: readonly ExtentState[];
    problem: string;
    bytes: number | undefined;
    scale: LengthScale;
  },
  actions: MeasureActions,
): TemplateResult {
  const { kind, measurements } = tool;
  return html`<div class="fields">
    <div class="chips" role="group" aria-label=${measureTexts.measure}>
      ${measurementKinds.map(
        (each) => html`<button
          type="button"
          class="chip"
          aria-pressed=${each === kind}
          @click=${() => tool.choose(each)}
        >
          ${measureTexts.kinds[each]}
        </button>`,
      )}
    </div>
    ${problem ? html`<p class="measurement-facts">${problem}</p>` : nothing}
    ${measurements.length > 0 ? list(tool, info, scale, actions) : nothing}
    <div class="chips">
      <button
        type="button"
        class="chip"
        title=${measureTexts.extentTitle}
        @click=${actions.measureSurfaces}
      >
        ${
          extents.some(({ share }) => share !== undefined)
            ? measureTexts.stop
            : html`${measureTexts.extent}${
                bytes === undefined
                  ? nothing
                  : html` <span class="quiet">${formatBytes(bytes)}</span>`
              }`
        }
      </button>
    </div>
    ${extents.map(progressPart)}
    <div role="status">${extents.map((each) => extentPart(each, scale.unit))}</div>
    <div class="chips" role="group" aria-label=${measureTexts.copyAndSave}>
      ${
        measurements.length > 0
          ? html`<button type="button" class="chip" @click=${actions.copy}>${measureTexts.copy}</button>
              <button type="button" class="chip" @click=${actions.saveCsv}>CSV</button>
              <button type="button" class="chip" @click=${actions.saveJson}>JSON</button>
              <button type="button" class="chip" @click=${(event: Event) => actions.remove("all", sectionOf(event))}>${measureTexts.removeAll}</button>`
          : nothing
      }
      <button
        type="button"
        class="chip"
        title=${measureTexts.saveSessionTitle}
        @click=${actions.saveSession}
      >
        ${measureTexts.saveSession}
      </button>
    </div>
  </div>`;
}

/** Not announced by screen readers. */
function progressPart({ isovalue, share }: ExtentState): TemplateResult | typeof nothing {
  if (share === undefined) return nothing;
  const name = measureTexts.isovalue(formatValue(isovalue));
  return html`<p class="measurement-facts">
    ${name}: <progress aria-label=${name} max="1" .value=${share}></progress> ${Math.round(100 * share)} %
  </p>`;
}

function extentPart({ isovalue, extent, problem }: ExtentState, unit: LengthUnit) {
  const name = measureTexts.isovalue(formatValue(isovalue));
  if (problem) return html`<p class="measurement-facts">${name}: ${problem}</p>`;
  if (!extent) return nothing;
  const { area, volumeAbove, gridVolume } = extent;
  const percent = localized(((100 * (volumeAbove ?? 0)) / gridVolume).toPrecision(3));
  return html`<p class="measurement-facts">
    ${name}: ${measureTexts.area} <b>${formatPower(area, 2, unit)}</b>,
    ${
      volumeAbove === undefined
        ? measureTexts.holes
        : html`${measureTexts.volume} <b>${formatPower(volumeAbove, 3, unit)}</b> (${percent} %)`
    }
  </p>`;
}

/** A new text does not change the points. */
function keyOf({ points }: Measurement): unknown {
  return points;
}

function sectionOf(event: Event): Element | null {
  return (event.currentTarget as Element).closest(".fields");
}

function list(
  tool: MeasureTool,
  info: StoreInfo,
  scale: LengthScale,
  actions: MeasureActions,
): TemplateResult {
  return html`<ol class="measurements" aria-label=${measureTexts.measurements}>
    ${repeat(tool.measurements, keyOf, (measurement, i) => {
      const name = `${measureTexts.kinds[measurement.kind]} ${i + 1}`;
      const more = facts(measurement, info, scale);
      return html`<li class="measurement">
        <span class="measurement-value">
          <span class="visually-hidden">${name}:</span> ${resultOf(measurement, scale)}
        </span>
        <button
          type="button"
          class="chip"
          title=${measureTexts.againTitle}
          aria-label=${measureTexts.againNamed(name)}
          @click=${() => tool.again(i)}
        >
          ${measureTexts.again}
        </button>
        <button
          type="button"
          class="chip measurement-remove"
          aria-label=${measureTexts.removeNamed(name)}
          @click=${(event: Event) => actions.remove(i, sectionOf(event))}
        >
          ${measureTexts.remove}
        </button>
        ${more ? html`<span class="measurement-facts quiet">${more}</span>` : nothing}
        <input
          class="small-input"
          type="text"
          aria-label=${measureTexts.textOf(name)}
          placeholder=${measureTexts.text}
          maxlength=${longestText}
          .value=${measurement.text ?? ""}
          @change=${(event: Event) => {
            const field = event.currentTarget as HTMLInputElement;
            tool.rename(i, field.value.trim());
            field.value = tool.measurements[i]?.text ?? "";
          }}
        />
      </li>`;
    })}
  </ol>`;
}
