import "./measure.css";
import type { TemplateResult } from "lit";
import type { StoreInfo } from "../../core/types.ts";
import { MeasureLayer } from "../../measure/measure_layer.ts";
import { MeasureTool } from "../../measure/measure_tool.ts";
import {
  angleOf,
  lengthOf,
  longestText,
  type Measurement,
  voxelOf,
} from "../../measure/measurement.ts";
import {
  type MeasurementRow,
  readMeasurement,
  toCsv,
  writeMeasurement,
} from "../../measure/measurement_text.ts";
import { movedMeasurement } from "../../measure/moved_measurement.ts";
import { type Session, writeSession } from "../../measure/session_file.ts";
import { type LengthUnit, unitOf } from "../../overlay/length_unit.ts";
import { measureTexts } from "../../texts/measure.ts";
import { messageOf } from "../../texts/without_options.ts";
import type { Layer } from "../../viewer/layer.ts";
import type { Respacing } from "../../viewer/respacing.ts";
import { sameValue } from "../../viewer/same_value.ts";
import { identity, scaleOf, volumeScaleOf } from "../../viewer/transform.ts";
import type { Viewer } from "../../viewer/viewer.ts";
import { forgetSession, keepSession, keptSession } from "../address/open_session.ts";
import { announcementOf, type Measured } from "./announcement.ts";
import { measureBar } from "./measure_bar.ts";
import { type ExtentState, type LengthScale, measureSection, resultOf } from "./measure_section.ts";

/** What is measured: a layer, or the viewer for its first one. */
export type MeasuredLayer = Pick<Viewer, "surfaces" | "bytesOf" | "storeAccess" | "info"> &
  Partial<Pick<Layer, "transform">>;

export interface MeasureHost {
  /** The layer whose surfaces are measured. */
  chosen(): MeasuredLayer;
  /** The title of a layer by its id; undefined if there is only one. */
  titleOfHit(layer: number): string | undefined;
  /** Measurements or the tool have changed. */
  changed(): void;
  /** Lays the page out after a change that does not affect the address. */
  render(): void;
  /** Lays the page out at once. */
  renderNow(): void;
  note(text: string): void;
  done(text: string): void;
  /** Offers a file to save. */
  save(name: string, type: string, text: string): void;
  /** The query of the present view's address. */
  view(): string;
}

/** Interval between two progress reports of an area (ms). */
const progressMs = 250;

/** Measurements in the page: tool, marks over the picture, section, link and files. */
export class Measure {
  readonly tool: MeasureTool;
  readonly #layer: MeasureLayer;
  readonly #viewer: Viewer;
  readonly #host: MeasureHost;
  /** The text for screen readers; undefined until the page's first measurements are shown. */
  #announced: string | undefined;
  #before: Measured = { measurements: [], draft: [] };
  #extents: readonly ExtentState[] = [];
  /** The volume that `#extents` are of. */
  #extentsOf: StoreInfo | null = null;
  #measuring: AbortController | null = null;
  /** The bytes for the isovalues in `key`. */
  #bytes: { key: string; bytes: number } | null = null;

  /** The content ids of the measured volume and of the volume that is shown. */
  #measured: string | undefined;
  #shown: string | undefined;
  /** The content id and the spacing of the volume that is open. */
  #shownGrid: string | undefined;
  /** The measurements of the scene, in the form of the address. */
  readonly #ofScene: readonly string[];
  /** Whether the address contained all measurements when it was last written. */
  #isInAddress = true;

  /** lines: the measurements in the address; undefined: those of the scene, `ofScene`. search: its query. */
  constructor(
    viewer: Viewer,
    host: MeasureHost,
    lines: readonly string[] | undefined,
    ofScene: readonly Measurement[],
    search: string,
  ) {
    this.#viewer = viewer;
    this.#host = host;
    this.tool = new MeasureTool(
      viewer,
      () => {
        this.#announce();
        this.#layer.request();
        if (this.tool.measurements.length === 0) this.#measured = this.#shown;
        host.changed();
      },
      host.titleOfHit,
    );
    this.#layer = new MeasureLayer(
      viewer,
      this.tool,
      (measurement) => resultOf(measurement, this.#scale),
      () => measureBar(this.tool, viewer.canvas, this.#announced ?? ""),
    );
    const kept = keptSession(search);
    const shown = ofScene.map(withShortText);
    this.#ofScene = shown.map(writeMeasurement);
    const read = kept?.measurements ?? lines?.map(readMeasurement) ?? shown;
    const known = read.filter((each) => each !== undefined);
    if (known.length < read.length) {
      const count = read.length - known.length;
      host.note(measureTexts.ignored(count, read.length));
    }
    this.#measured = kept?.contentId;
    if (known.length > 0) this.tool.set(known);
    this.#announced = "";
    if (viewer.info) this.#opened(viewer.info);
    viewer.on("opened", (info) => this.#opened(info));
  }

  #announce(): void {
    const before = this.#before;
    const { measurements, draft } = this.tool;
    this.#before = { measurements, draft };
    if (this.#announced === undefined) return;
    const text = announcementOf(before, this.#before, (each) => resultOf(each, this.#scale));
    if (text === undefined) return;
    this.#announced = spoken(text, this.#announced);
  }

  /** The element over the canvas. */
  get element(): HTMLElement {
    return this.#layer.element;
  }

  /** The measurements with the texts beside them. */
  get labelled(): { measurement: Measurement; label: string }[] {
    return this.tool.measurements.map((measurement) => ({
      measurement,
      label: resultOf(measurement, this.#scale),
    }));
  }

  /** The measurements in the form of the address; null if they are those of the scene. */
  get lines(): readonly string[] | null {
    const lines = this.#linesOfTool;
    return sameValue(lines, this.#ofScene) ? null : lines;
  }

  get #linesOfTool(): string[] {
    return this.tool.measurements.map(writeMeasurement);
  }

  /** Shows the measurements of an earlier view: `known`, or if it is null, those of `lines` (see there). */
  restore(lines: readonly string[] | null, known: readonly Measurement[] | null): void {
    if (known ? sameValue(known, this.tool.measurements) : sameValue(lines, this.lines)) return;
    const read = known ?? (lines ?? this.#ofScene).map(readMeasurement);
    const said = this.#announced;
    this.#setSilently(read.filter((each) => each !== undefined));
    this.#announced = spoken(measureTexts.count(this.tool.measurements.length), said);
  }

  /** The voxels have moved, and the measurements move along with them. */
  respace(change: Respacing): void {
    this.#setSilently(this.tool.measurements.map((each) => movedMeasurement(each, change)));
    this.#announced = "";
  }

  /** Without results: the unit of lengths may be about to change. */
  #setSilently(measurements: readonly Measurement[]): void {
    this.#announced = undefined;
    this.tool.set(measurements);
  }

  /** A volume was opened, which may be another version of the measured one. */
  #opened({ contentId, spacing }: StoreInfo): void {
    const key = [contentId, ...spacing].join();
    if (key === this.#shownGrid) return;
    this.#shownGrid = key;
    this.#measuring?.abort();
    this.#extents = [];
    this.#bytes = null;
    if (contentId === this.#shown) return;
    this.#shown = contentId;
    this.#measured ??= contentId;
    if (this.#isOfOther) this.#host.note(measureTexts.otherVersion);
  }

  get #isOfOther(): boolean {
    return this.tool.measurements.length > 0 && this.#measured !== this.#shown;
  }

  /**
   * The address was written, with all measurements or with none. Values and normals are not in the address: this tab
   * keeps them, so that they are there after a reload.
   */
  rested(isInAddress: boolean): void {
    if (isInAddress) {
      const isWhole = sameValue(this.tool.measurements, this.#linesOfTool.map(readMeasurement));
      if (isWhole || !keepSession(location.search, this.#session())) forgetSession();
    } else if (!keepSession(location.search, this.#session()) || this.#isInAddress) {
      this.#host.note(measureTexts.notInAddress);
    }
    this.#isInAddress = isInAddress;
  }

  section(info: StoreInfo): TemplateResult {
    const { info: measured } = this.#host.chosen();
    if (this.#extents.length > 0 && measured !== this.#extentsOf) {
      this.#measuring?.abort();
      this.#extents = [];
    }
    const problem = this.#isOfOther ? measureTexts.otherVersion : "";
    return measureSection(
      this.tool,
      info,
      {
        extents: this.#extents,
        problem,
        bytes: this.#bytesToMeasure(),
        scale: this.#scale,
      },
      {
        remove: (index, list) => this.#remove(index, list),
        measureSurfaces: () => void this.#measureSurfaces(),
        copy: () => void this.#copy(),
        saveCsv: () =>
          this.#host.save("measurements.csv", "text/csv", toCsv(this.#rows(), this.#unit)),
        saveJson: () => {
          const text = `${JSON.stringify(this.#rows(), null, 2)}\n`;
          this.#host.save("measurements.json", "application/json", text);
        },
        saveSession: () => this.saveSession(),
      },
    );
  }

  get #unit(): LengthUnit {
    const { info } = this.#viewer;
    return info ? unitOf(info) : "mm";
  }

  /** By the smallest edge of a voxel of all volumes, and the unit of the first one. */
  get #scale(): LengthScale {
    const edges = this.#viewer.layers.map(({ info, transform }) =>
      info ? Math.min(...info.spacing) * Math.cbrt(volumeScaleOf(transform)) : Infinity,
    );
    return { voxelMm: Math.min(...edges), unit: this.#unit };
  }

  /**
   * The bytes to fetch for area and volume of the surfaces, if they are known and the view is at
   * rest.
   */
  #bytesToMeasure(): number | undefined {
    const layer = this.#host.chosen();
    const isovalues = layer.surfaces.map(({ isovalue }) => isovalue);
    const key = [layer.info?.contentId, ...isovalues].join();
    if (this.#bytes?.key === key) return this.#bytes.bytes;
    if (this.#viewer.isBusy) return undefined;
    let bytes = 0;
    for (const isovalue of isovalues) bytes += layer.bytesOf(isovalue) ?? Number.NaN;
    if (Number.isNaN(bytes)) return undefined;
    this.#bytes = { key, bytes };
    return bytes;
  }

  /**
   * Computes area and volume of each isosurface, one after the other. A second call stops the
   * first.
   */
  async #measureSurfaces(): Promise<void> {
    if (this.#measuring) {
      this.#measuring.abort();
      return;
    }
    const measuring = new AbortController();
    this.#measuring = measuring;
    this.#extents = [];
    try {
      const layer = this.#host.chosen();
      this.#extentsOf = layer.info;
      for (const { isovalue } of layer.surfaces) await this.#extentOf(layer, isovalue, measuring);
    } catch (error) {
      if (measuring.signal.aborted) this.#extents = this.#extents.filter(({ extent }) => extent);
      else {
        const problem = messageOf(error);
        this.#extents = this.#extents.map((each) =>
          each.extent ? each : { isovalue: each.isovalue, problem },
        );
      }
    } finally {
      this.#measuring = null;
      this.#host.render();
    }
  }

  async #extentOf(
    layer: MeasuredLayer,
    isovalue: number,
    { signal }: AbortController,
  ): Promise<void> {
    const before = this.#extents;
    let shownAt = 0;
    const show = (state: Omit<ExtentState, "isovalue">): void => {
      this.#extents = [...before, { isovalue, ...state }];
      shownAt = performance.now();
      this.#host.render();
    };
    const scale = scaleOf(layer.transform ?? identity);
    if (scale === undefined) {
      show({ problem: measureTexts.isDistorted });
      return;
    }
    show({ share: 0 });
    const { SurfaceReader, surfaceExtent } = await import("../../mesh/index.ts");
    const access = layer.storeAccess;
    if (!access) return;
    const extent = await surfaceExtent(new SurfaceReader(access), isovalue, {
      signal,
      progress: (share) => {
        if (performance.now() - shownAt > progressMs) show({ share });
      },
    });
    const { area, volumeAbove, gridVolume } = extent;
    show({
      extent: {
        ...extent,
        area: area * scale ** 2,
        ...(volumeAbove !== undefined && { volumeAbove: volumeAbove * scale ** 3 }),
        gridVolume: gridVolume * scale ** 3,
      },
    });
  }

  /** If the focused button is removed, the next one gets the focus, or the first tool. */
  #remove(index: number | "all", section: Element | null): void {
    if (index === "all") this.tool.clear();
    else this.tool.remove(index);
    this.#host.renderNow();
    const buttons = section?.querySelectorAll<HTMLElement>(".measurement-remove");
    const next = buttons?.[Math.min(Number(index), buttons.length - 1)];
    (next ?? section?.querySelector<HTMLElement>(".chip"))?.focus();
  }

  saveSession(): void {
    this.#host.save("session.isosplat.json", "application/json", writeSession(this.#session()));
  }

  #session(): Session {
    const contentId = this.#measured;
    const { measurements } = this.tool;
    return { view: this.#host.view(), ...(contentId && { contentId }), measurements };
  }

  async #copy(): Promise<void> {
    try {
      await navigator.clipboard.writeText(toCsv(this.#rows(), this.#unit));
      this.#host.done(measureTexts.copied);
    } catch {
      this.#host.note(measureTexts.noClipboard);
    }
  }

  #rows(): MeasurementRow[] {
    return this.tool.measurements.map((measurement) => rowOf(measurement, this.#viewer.info));
  }
}

/** Screen readers speak a text only if it differs from the one before: `said`. */
function spoken(text: string, said: string | undefined): string {
  return text === said ? `${text}\u00a0` : text;
}

/** Texts of scenes may be longer than those of the page. */
function withShortText({ text, ...measurement }: Measurement): Measurement {
  return { ...measurement, ...(text && { text: text.slice(0, longestText) }) };
}

function lengthIn(unit: LengthUnit, length: number) {
  return unit === "mm" ? { length_mm: length } : { length_voxels: length };
}

function rowOf(measurement: Measurement, info: StoreInfo | null): MeasurementRow {
  const { kind, points } = measurement;
  const unit = info ? unitOf(info) : "mm";
  const angle = kind === "angle" ? angleOf(points) : undefined;
  return {
    ...measurement,
    voxels: info ? points.map(({ position, voxel }) => voxel ?? voxelOf(info, position)) : [],
    ...((kind === "distance" || kind === "path") && lengthIn(unit, lengthOf(points))),
    ...(angle !== undefined && { angle_degrees: angle }),
  };
}
