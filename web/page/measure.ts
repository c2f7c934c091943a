import "./measure.css";
import type { TemplateResult } from "lit";
import { MeasureLayer } from "../measure/measure_layer.ts";
import { MeasureTool } from "../measure/measure_tool.ts";
import { angleOf, lengthOf, type Measurement, voxelOf } from "../measure/measurement.ts";
import {
  type MeasurementRow,
  readMeasurement,
  toCsv,
  writeMeasurement,
} from "../measure/measurement_text.ts";
import { writeSession } from "../measure/session_file.ts";
import type { StoreInfo } from "../stream/types.ts";
import type { Viewer } from "../viewer/index.ts";
import { measureSection, resultOf } from "./measure_section.ts";
import { keptMeasurements } from "./open_session.ts";

export interface MeasureHost {
  /** Measurements or the tool have changed. */
  changed(): void;
  note(text: string): void;
  done(text: string): void;
  /** Offers a file to save. */
  save(name: string, type: string, text: string): void;
  /** The query of the address of the present view. */
  view(): string;
}

/** Measurements in the page: tool, marks above the picture, section, link and files. */
export class Measure {
  readonly tool: MeasureTool;
  readonly #layer: MeasureLayer;
  readonly #viewer: Viewer;
  readonly #host: MeasureHost;

  /** lines: the measurements of the address. */
  constructor(viewer: Viewer, host: MeasureHost, lines: readonly string[]) {
    this.#viewer = viewer;
    this.#host = host;
    this.tool = new MeasureTool(viewer, () => {
      this.#layer.request();
      host.changed();
    });
    this.#layer = new MeasureLayer(viewer, this.tool, resultOf);
    const kept = keptMeasurements(lines);
    const read = kept ?? lines.map(readMeasurement);
    const known = read.filter((each) => each !== undefined);
    if (known.length < read.length) {
      const count = read.length - known.length;
      host.note(
        `${count} of ${read.length} measurements in the address were ignored: expected kind,x,y,z.`,
      );
    }
    if (known.length > 0) this.tool.set(known);
  }

  /** Lies on the canvas. */
  get element(): HTMLElement {
    return this.#layer.element;
  }

  /** As the address has them. */
  get lines(): readonly string[] {
    return this.tool.measurements.map(writeMeasurement);
  }

  section(info: StoreInfo): TemplateResult {
    return measureSection(this.tool, info, {
      copy: () => void this.#copy(),
      saveCsv: () => this.#host.save("measurements.csv", "text/csv", toCsv(this.#rows())),
      saveJson: () => {
        const text = `${JSON.stringify(this.#rows(), null, 2)}\n`;
        this.#host.save("measurements.json", "application/json", text);
      },
      saveSession: () => this.saveSession(),
    });
  }

  saveSession(): void {
    const contentId = this.#viewer.info?.contentId;
    const session = writeSession({
      view: this.#host.view(),
      ...(contentId && { contentId }),
      measurements: this.tool.measurements,
    });
    this.#host.save("session.isosplat.json", "application/json", session);
  }

  async #copy(): Promise<void> {
    try {
      await navigator.clipboard.writeText(toCsv(this.#rows()));
      this.#host.done("Measurements copied");
    } catch {
      this.#host.note("The browser does not allow access to the clipboard: save them instead");
    }
  }

  #rows(): MeasurementRow[] {
    return this.tool.measurements.map((measurement) => rowOf(measurement, this.#viewer.info));
  }
}

function rowOf(measurement: Measurement, info: StoreInfo | null): MeasurementRow {
  const { kind, points } = measurement;
  const angle = kind === "angle" ? angleOf(points) : undefined;
  return {
    ...measurement,
    voxels: info ? points.map(({ position }) => voxelOf(info, position)) : [],
    ...((kind === "distance" || kind === "path") && { length: lengthOf(points) }),
    ...(angle !== undefined && { angle }),
  };
}
