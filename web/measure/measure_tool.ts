import { measureTexts } from "../texts/measure.ts";
import { listenToClicks } from "../viewer/clicks.ts";
import type { Viewer } from "../viewer/viewer.ts";
import {
  isText,
  type MeasuredField,
  type MeasuredPoint,
  type Measurement,
  type MeasurementKind,
  mostMeasurements,
  mostPointsInAll,
  pointCounts,
  withinLimits,
} from "./measurement.ts";

/** One point of a measurement, by its indices. */
export interface PointPlace {
  measurement: number;
  point: number;
}

/**
 * The measurements of a volume, and the tool that adds points to them: a click or a tap on the
 * surface, or Enter for the middle of the picture. Drags still rotate the view; those of a point
 * move it along the surface.
 */
export class MeasureTool {
  readonly #viewer: Viewer;
  readonly #changed: () => void;
  readonly #titleOf: (layer: number) => string | undefined;
  readonly #listeners = new AbortController();
  #measurements: readonly Measurement[] = [];
  #kind: MeasurementKind | null = null;
  #draft: readonly MeasuredPoint[] = [];
  /** The point that is being moved, and the place on the surface that it is above. */
  #moved: { place: PointPlace; to: MeasuredPoint | undefined } | null = null;
  /** The index of the measurement that the draft replaces; null: none. */
  #replaced: number | null = null;
  /** Why the last click found no point; null if it found one. */
  #miss: string | null = null;

  /** `titleOf`: the title of a layer by its id; undefined if there is only one. */
  constructor(
    viewer: Viewer,
    changed: () => void,
    titleOf: (layer: number) => string | undefined = () => undefined,
  ) {
    this.#viewer = viewer;
    this.#titleOf = titleOf;
    this.#changed = changed;
    const { signal } = this.#listeners;
    const { canvas } = viewer;
    listenToClicks(canvas, (event) => this.#clicked(event), signal);
    canvas.addEventListener("keydown", (event) => this.#key(event), { signal });
  }

  stop(): void {
    this.#listeners.abort();
  }

  get measurements(): readonly Measurement[] {
    return this.#measurements;
  }

  /** `measurements`, with the point that is being moved at its new place. */
  get shown(): readonly Measurement[] {
    const { place, to } = this.#moved ?? {};
    if (!place || !to) return this.#measurements;
    return this.#measurements.map((measurement, i) =>
      i === place.measurement
        ? { ...measurement, points: measurement.points.with(place.point, to) }
        : measurement,
    );
  }

  /** Points of the unfinished measurement. */
  get draft(): readonly MeasuredPoint[] {
    return this.#draft;
  }

  /** The kind of measurement that clicks on the surface add to; null if clicks have no effect. */
  get kind(): MeasurementKind | null {
    return this.#kind;
  }

  get miss(): string | null {
    return this.#miss;
  }

  set(measurements: readonly Measurement[]): void {
    this.#measurements = withinLimits(measurements);
    this.#draft = [];
    this.#moved = null;
    this.#replaced = null;
    this.#changed();
  }

  /** Begins measurements of a kind, or ends them if it is the present one. */
  choose(kind: MeasurementKind | null): void {
    this.finish();
    this.#replaced = null;
    this.#begin(kind === this.#kind ? null : kind);
  }

  /** Measures one again: the next measurement takes its place, and its text. */
  again(index: number): void {
    const measurement = this.#measurements[index];
    if (!measurement) return;
    this.finish();
    this.#replaced = index;
    this.#begin(measurement.kind);
  }

  #begin(kind: MeasurementKind | null): void {
    this.#kind = kind;
    // While the tool is active, it handles Enter, Backspace and Escape on the picture.
    if (this.#kind) this.#viewer.canvas.focus({ preventScroll: true });
    this.#miss = null;
    this.#viewer.canvas.style.cursor = this.#kind ? "crosshair" : "";
    this.#changed();
  }

  /** Ends a path, and discards incomplete measurements. */
  finish(): void {
    const draft = this.#draft;
    this.#draft = [];
    if (this.#kind && draft.length >= pointCounts[this.#kind][0]) this.#add(this.#kind, draft);
    else if (draft.length > 0) this.#changed();
  }

  /** Removes the last point of the unfinished measurement. */
  takeBack(): void {
    this.#draft = this.#draft.slice(0, -1);
    this.#changed();
  }

  /** A note keeps its text if the new one is empty. */
  rename(index: number, text: string): void {
    this.#measurements = this.#measurements.map((measurement, i) => {
      const { kind, points } = measurement;
      if (i !== index || !isText(kind, text)) return measurement;
      return { kind, points, ...(text !== "" && { text }) };
    });
    this.#changed();
  }

  remove(index: number): void {
    this.#replaced = null;
    this.#measurements = this.#measurements.filter((_, i) => i !== index);
    this.#changed();
  }

  clear(): void {
    this.set([]);
  }

  /** Adds the point of the surface at a position on the canvas, in CSS pixels. */
  pick(x: number, y: number): void {
    const kind = this.#kind;
    if (!kind) return;
    const point = this.#pointAt(x, y);
    this.#miss = point ? null : measureTexts.missed;
    if (!point) {
      this.#changed();
      return;
    }
    const draft = [...this.#draft, point];
    this.#draft = draft;
    if (draft.length < pointCounts[kind][1]) {
      this.#changed();
      return;
    }
    this.#draft = [];
    this.#add(kind, draft);
  }

  /**
   * Shows a point of a measurement at a position on the canvas, until `drop`. It stays where it was
   * last on the surface.
   */
  move(place: PointPlace, x: number, y: number): void {
    const to = this.#pointAt(x, y) ?? this.#moved?.to;
    this.#moved = { place, to };
  }

  /** Ends a move. `keep`: else the point returns to where it was. */
  drop(keep: boolean): void {
    if (keep) this.#measurements = this.shown;
    this.#moved = null;
    this.#changed();
  }

  #pointAt(x: number, y: number): MeasuredPoint | undefined {
    const found = this.#viewer.pick(x, y);
    if (!found) return undefined;
    const { position, isovalue: value, normal, level, voxel } = found;
    const layer = this.#titleOf(found.layer);
    const field = this.#fieldOf(found.field);
    return {
      ...{ position, value, normal, level },
      ...(layer !== undefined && { layer, voxel }),
      ...(field && { field }),
    };
  }

  /** `value`: undefined while it has not arrived, NaN where the field has none. */
  #fieldOf(value: number | undefined): MeasuredField | undefined {
    const { look, legend } = this.#viewer;
    if (value === undefined || Number.isNaN(value) || look.colourBy !== "field") return undefined;
    const units = legend?.field?.units;
    const label = legend?.categories?.find((each) => each.value === value)?.name;
    return { name: look.field.name, value, ...(units && { units }), ...(label && { label }) };
  }

  #add(kind: MeasurementKind, points: readonly MeasuredPoint[]): void {
    const replaced = this.#replaced === null ? undefined : this.#measurements[this.#replaced];
    if (replaced) {
      const { text } = replaced;
      const measured = { kind, points, ...(text !== undefined && { text }) };
      this.#measurements = this.#measurements.with(this.#replaced ?? 0, measured);
      this.#replaced = null;
      this.#begin(null);
      return;
    }
    const text =
      kind === "note" ? { text: measureTexts.newNote(this.#measurements.length + 1) } : {};
    const more = [...this.#measurements, { kind, points, ...text }];
    if (withinLimits(more).length < more.length) {
      this.#miss = measureTexts.tooMany(mostMeasurements, mostPointsInAll);
    } else this.#measurements = more;
    this.#changed();
  }

  #clicked({ clientX, clientY }: PointerEvent): void {
    const box = this.#viewer.canvas.getBoundingClientRect();
    this.pick(clientX - box.left, clientY - box.top);
  }

  #key(event: KeyboardEvent): void {
    if (!this.#kind || event.ctrlKey || event.metaKey || event.altKey) return;
    const { canvas } = this.#viewer;
    if (event.key === "Enter") {
      if (event.shiftKey) this.finish();
      else this.pick(canvas.clientWidth / 2, canvas.clientHeight / 2);
    } else if (event.key === "Backspace" && this.#draft.length > 0) this.takeBack();
    else if (event.key === "Escape") this.choose(null);
    else return;
    event.preventDefault();
  }
}
