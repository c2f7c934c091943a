import type { StoreInfo } from "../../core/types.ts";
import { listed } from "../../texts/numbers.ts";
import { pageTexts } from "../../texts/page.ts";
import { panelTexts } from "../../texts/panel.ts";
import { surfacesAt } from "../../viewer/surfaces.ts";
import { maxSurfaces, type Surface } from "../../viewer/types.ts";
import type { Viewer } from "../../viewer/viewer.ts";
import type { UrlState } from "../address/url_state.ts";
import { formatValue } from "../shell/format.ts";
import type { HistogramMark } from "./histogram.ts";
import {
  firstIsovalue,
  type IsovalueScale,
  isovalueScale,
  roundToScale,
} from "./isovalue_scale.ts";
import { IsovalueSweep } from "./isovalue_sweep.ts";
import type { VolumeActions, VolumeState } from "./panel_state.ts";
import { withAddedSurface } from "./surfaces.ts";

/** Screen readers are told an isovalue after this time without changes (ms): once for a key that is held. */
const announceAfter = 500;

/** A layer whose surfaces are changed. */
export interface SurfaceSubject {
  surfaces: readonly Surface[];
  /** Null until its store has been read. */
  readonly info: StoreInfo | null;
}

/**
 * The surfaces of the chosen layer, and the changes of their isovalues. At first, the volume of the
 * page is chosen, with the surfaces of the address. Passes every change to the viewer, and then
 * notifies the page. The visitor's surfaces are stored here, since the viewer shows others while a
 * film is drawn, and none before a volume is open.
 */
export class SurfaceSettings {
  readonly #viewer: Viewer;
  readonly #url: UrlState;
  readonly #changed: (isIsovalueOnly?: boolean) => void;
  /** The chosen layer. Null if it is the volume of the page, which is the viewer's first layer. */
  #subject: SurfaceSubject | null = null;
  #scale: IsovalueScale = { low: 0, high: 1, step: 0.01 };
  #suggestions: readonly number[] = [];
  #surfaces: readonly Surface[];
  /** The isovalue that a volume's first suggestion has set. */
  #suggested: number | undefined;
  /** The surface that the slider and the keys change. */
  #active = 0;
  #isLogarithmic = true;
  #sweepSeconds = 10;
  #typed: string | undefined;
  #announced = "";
  #announcing: ReturnType<typeof setTimeout> | undefined;
  readonly #sweep = new IsovalueSweep((value) =>
    this.#setIsovalue(roundToScale(value, this.#scale)),
  );

  /** changed: `isIsovalueOnly` if nothing but the isovalue of the active surface has changed. */
  constructor(viewer: Viewer, url: UrlState, changed: (isIsovalueOnly?: boolean) => void) {
    this.#viewer = viewer;
    this.#url = url;
    this.#changed = (isIsovalueOnly) => {
      this.#endAnnouncement();
      changed(isIsovalueOnly);
    };
    this.#surfaces = surfacesAt(url.isovalues ?? [], url.colours, url.opacities);
  }

  /** The chosen layer. Null if it is the volume of the page. */
  get subject(): SurfaceSubject | null {
    return this.#subject;
  }

  /** Chooses the layer whose surfaces are changed from now on. Null: the volume of the page. */
  choose(subject: SurfaceSubject | null): void {
    this.#sweep.stop();
    this.#subject = subject;
    this.#typed = undefined;
    this.#active = 0;
    this.reread();
  }

  /** The chosen layer was opened, or its surfaces were changed elsewhere. */
  reread(): void {
    const { info, surfaces } = this.#subject ?? this.#viewer;
    if (info) this.#scaleTo(info);
    this.#surfaces = surfaces;
    this.#active = Math.max(0, Math.min(this.#active, surfaces.length - 1));
    this.#changed();
  }

  #scaleTo(info: StoreInfo): void {
    this.#scale = isovalueScale(info.range, info.mapping.scale);
    this.#suggestions = info.metadata.suggested_isovalues ?? [];
  }

  /** The surfaces of the volume of the page, whichever layer is chosen. */
  get first(): readonly Surface[] {
    return this.#subject ? this.#viewer.surfaces : this.#surfaces;
  }

  /** Empty until the address or a volume provides an isovalue. */
  get surfaces(): readonly Surface[] {
    return this.#surfaces;
  }

  /** Whether the only isovalue is the store's suggestion, and not a choice of the visitor. */
  get hasSuggested(): boolean {
    return this.#surfaces.length === 1 && this.#surfaces[0]?.isovalue === this.#suggested;
  }

  /**
   * Call it when the volume of the page has been opened and is chosen. Sets its range. Uses the
   * first suggested isovalue if no isovalue lies inside the range, or if the present one was
   * suggested by the previous volume. `hasOwn`: the viewer has surfaces of a scene, which stay.
   * Returns a sentence for each setting that differs from the address.
   */
  opened(info: StoreInfo, hasOwn = false): string[] {
    this.#sweep.stop();
    if (hasOwn) {
      this.reread();
      return [];
    }
    this.#scaleTo(info);
    const notes: string[] = [];
    const { low, high } = this.#scale;
    const isInside = ({ isovalue }: Surface) => isovalue >= low && isovalue <= high;
    const before = this.hasSuggested ? [] : this.#surfaces;
    const outside = before.filter((surface) => !isInside(surface));
    if (outside.length > 0) {
      const values = listed(outside.map(({ isovalue }) => formatValue(isovalue)));
      notes.push(pageTexts.isovaluesOutside(values, formatValue(low), formatValue(high)));
    }
    let surfaces: readonly Surface[] = before.filter(isInside);
    if (surfaces.length === 0) {
      const { colours, opacities } = this.#url;
      const isovalue = firstIsovalue(info);
      this.#suggested = isovalue;
      // The visitor may have chosen a colour.
      surfaces = surfacesAt([isovalue], colours, opacities).map((surface) => ({
        ...surface,
        ...this.#surfaces[0],
        isovalue,
      }));
    }
    if (outside.length > 0 || before.length === 0) {
      this.#surfaces = surfaces;
      this.#active = Math.min(this.#active, surfaces.length - 1);
      this.#viewer.setSurfaces(surfaces);
    }
    this.#changed();
    return notes;
  }

  /** Called when the volume is no longer open. */
  closed(): void {
    this.#sweep.stop();
    this.#endAnnouncement();
  }

  /** Moves the active surface by `by` hundredths of the range, or by `by` single steps. */
  step(by: number, unit: "hundredth" | "step"): void {
    const { low, high, step } = this.#scale;
    const isovalue = this.#surfaces[this.#active]?.isovalue;
    if (isovalue === undefined) return;
    const width = unit === "step" ? step : Math.max(step, (high - low) / 100);
    this.actions.slide(isovalue + by * width);
    this.#announce();
  }

  /**
   * What screen readers say of a change that no focused control shows, by a key, the wheel, undo or redo: the isovalue
   * of the active surface, once it rests. Empty after any other change.
   */
  get announced(): string {
    return this.#announced;
  }

  #announce(): void {
    this.#endAnnouncement();
    this.#announcing = setTimeout(() => {
      const isovalue = this.#surfaces[this.#active]?.isovalue;
      if (isovalue === undefined) return;
      this.#changed();
      const units = (this.#subject ?? this.#viewer).info?.metadata.units;
      const words = [panelTexts.isovalue, formatValue(isovalue), units ?? ""];
      this.#announced = words.join(" ").trim();
    }, announceAfter);
  }

  #endAnnouncement(): void {
    clearTimeout(this.#announcing);
    this.#announced = "";
  }

  get state(): Omit<
    VolumeState,
    "info" | "histogram" | "bytes" | "fieldBins" | "hasLabels" | "offered"
  > {
    return {
      scale: this.#scale,
      surfaces: this.#surfaces,
      active: this.#active,
      isLogarithmic: this.#isLogarithmic,
      typed: this.#typed,
      isSweeping: this.#sweep.isRunning,
      sweepSeconds: this.#sweepSeconds,
    };
  }

  /** Restores earlier surfaces of the volume of the page, for undo and redo. */
  restore(surfaces: readonly Surface[]): void {
    if (this.#subject) {
      this.#viewer.setSurfaces(surfaces);
      return;
    }
    this.#sweep.stop();
    this.#active = Math.max(0, Math.min(this.#active, surfaces.length - 1));
    const before = this.#surfaces[this.#active]?.isovalue;
    const isovalue = surfaces[this.#active]?.isovalue;
    this.#setSurfaces(surfaces);
    if (isovalue !== before) this.#announce();
  }

  get suggestions(): readonly number[] {
    return this.#suggestions;
  }

  /** The surfaces as marks on the histogram. */
  get marks(): HistogramMark[] {
    return this.#surfaces.map((surface, i) => ({
      value: surface.isovalue,
      colour: surface.colour,
      isActive: i === this.#active,
    }));
  }

  readonly actions: Omit<VolumeActions, "saveSurface"> = {
    slide: (value) => {
      this.#sweep.stop();
      this.#setIsovalue(roundToScale(value, this.#scale));
    },
    enter: (value) => {
      this.#sweep.stop();
      this.#setIsovalue(value);
    },
    toggleLogarithmic: () => {
      this.#isLogarithmic = !this.#isLogarithmic;
      this.#changed();
    },
    toggleSweep: () => this.#toggleSweep(),
    type: (text) => {
      if (text === this.#typed) return;
      this.#sweep.stop();
      this.#typed = text;
      this.#changed();
    },
    setSweepSeconds: (seconds) => {
      this.#sweepSeconds = seconds;
      if (this.#sweep.isRunning) this.#startSweep();
      this.#changed();
    },
    activate: (index) => {
      if (index >= this.#surfaces.length) return;
      this.#sweep.stop();
      this.#active = index;
      this.#changed();
    },
    changeSurface: (index, change) => this.#changeSurface(index, change),
    addSurface: () => {
      if (this.#surfaces.length >= maxSurfaces) return;
      this.#sweep.stop();
      this.#active = this.#surfaces.length;
      this.#setSurfaces(withAddedSurface(this.#surfaces, this.#suggestions, this.#scale));
    },
    removeSurface: (index) => {
      if (index >= this.#surfaces.length || this.#surfaces.length === 1) return;
      this.#sweep.stop();
      const left = this.#surfaces.filter((_, i) => i !== index);
      const wasBefore = index < this.#active ? 1 : 0;
      this.#active = Math.min(this.#active - wasBefore, left.length - 1);
      this.#setSurfaces(left);
    },
  };

  #toggleSweep(): void {
    if (this.#sweep.isRunning) this.#sweep.stop();
    else this.#startSweep();
    this.#changed();
  }

  #startSweep(): void {
    const { low, high } = this.#scale;
    const isovalue = this.#surfaces[this.#active]?.isovalue;
    if (isovalue !== undefined) this.#sweep.start(isovalue, low, high, this.#sweepSeconds);
  }

  #setSurfaces(surfaces: readonly Surface[], isIsovalueOnly = false): void {
    this.#surfaces = surfaces;
    if (this.#subject) this.#subject.surfaces = surfaces;
    else this.#viewer.setSurfaces(surfaces);
    this.#changed(isIsovalueOnly);
  }

  #changeSurface(index: number, change: Partial<Surface>, isIsovalueOnly = false): void {
    const changed = this.#surfaces.map((s, i) => (i === index ? { ...s, ...change } : s));
    this.#setSurfaces(changed, isIsovalueOnly);
  }

  #setIsovalue(isovalue: number): void {
    const { low, high } = this.#scale;
    const inside = Math.max(low, Math.min(high, isovalue));
    if (this.#surfaces[this.#active]?.isovalue === inside) this.#changed();
    else this.#changeSurface(this.#active, { isovalue: inside }, true);
  }
}
