import { defaultParts, type OverlayPart } from "../../overlay/parts.ts";
import type { StoreInfo } from "../../stream/index.ts";
import { listed } from "../../texts/numbers.ts";
import { pageTexts } from "../../texts/page.ts";
import {
  type Clip,
  defaultLook,
  type Look,
  noSlices,
  planeFacing,
  type Surface,
  surfacesAt,
  turnedLight,
  type Viewer,
  wholeVolume,
} from "../../viewer/index.ts";
import type { AddressState } from "../address/page_address.ts";
import type { UrlState } from "../address/url_state.ts";
import { formatValue } from "../shell/format.ts";
import { theme, themeBackground } from "../shell/theme.ts";
import type { HistogramMark } from "./histogram.ts";
import {
  firstIsovalue,
  type IsovalueScale,
  isovalueScale,
  roundToScale,
} from "./isovalue_scale.ts";
import { IsovalueSweep } from "./isovalue_sweep.ts";
import type { PanelActions, PanelState } from "./panel_state.ts";
import { withAddedSurface } from "./surfaces.ts";

/**
 * What the viewer shows and how: surfaces, appearance, clipping, slices. Starts with the settings of the
 * address; passes every change to the viewer, then notifies the page. The viewer keeps appearance,
 * clipping and slices. The surfaces that the visitor has chosen are here: the viewer shows others while
 * a film is made, and none before a volume is open.
 */
export class DisplaySettings {
  readonly #viewer: Viewer;
  readonly #url: UrlState;
  readonly #changed: () => void;
  #scale: IsovalueScale = { low: 0, high: 1, step: 0.01 };
  #suggestions: readonly number[] = [];
  #surfaces: readonly Surface[];
  /** The isovalue that a volume's first suggestion has set. */
  #suggested: number | undefined;
  /** The surface that the slider and the keys change. */
  #active = 0;
  #isThemeBackground: boolean;
  #show: ReadonlySet<OverlayPart>;
  #isLogarithmic = true;
  #sweepSeconds = 10;
  #typed: string | undefined;
  readonly #sweep = new IsovalueSweep((value) =>
    this.#setIsovalue(roundToScale(value, this.#scale)),
  );

  constructor(viewer: Viewer, url: UrlState, changed: () => void) {
    this.#viewer = viewer;
    this.#url = url;
    this.#changed = changed;
    this.#surfaces = surfacesAt(url.isovalues ?? [], url.colours, url.opacities);
    this.#isThemeBackground = url.background === undefined;
    viewer.setLook({
      kind: url.kind ?? defaultLook.kind,
      shading: url.shading ?? defaultLook.shading,
      colourBy: url.colourBy ?? defaultLook.colourBy,
      colourMap: url.colourMap ?? defaultLook.colourMap,
      light: url.light ?? defaultLook.light,
      eyeDome: url.eyeDome ?? defaultLook.eyeDome,
      background: url.background ?? themeBackground[theme()],
    });
    viewer.setClip(url.clip ?? wholeVolume);
    viewer.setSlices(url.slices ?? noSlices);
    this.#show = url.show ?? defaultParts;
    viewer.on("light", changed);
  }

  /** Empty until the address or a volume provides an isovalue. */
  get surfaces(): readonly Surface[] {
    return this.#surfaces;
  }

  /** There is one isovalue, which a store has suggested: the visitor has not chosen it. */
  get hasSuggested(): boolean {
    return this.#surfaces.length === 1 && this.#surfaces[0]?.isovalue === this.#suggested;
  }

  /**
   * Called when a volume is open. Sets its range; if no isovalue lies inside it, uses the first
   * suggested isovalue, as it does in place of one that was suggested before. Returns a sentence for each setting that differs from the address.
   */
  opened(info: StoreInfo): string[] {
    this.#sweep.stop();
    this.#scale = isovalueScale(info.range, info.mapping.scale);
    this.#suggestions = info.metadata.suggested_isovalues ?? [];
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
      // A colour may have been chosen.
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
  }

  themeChanged(): void {
    if (this.#isThemeBackground) this.#changeLook({ background: themeBackground[theme()] });
  }

  /** Moves the active surface by `by` hundredths of the range, or by `by` single steps. */
  step(by: number, unit: "hundredth" | "step"): void {
    const { low, high, step } = this.#scale;
    const isovalue = this.#surfaces[this.#active]?.isovalue;
    if (isovalue === undefined) return;
    const width = unit === "step" ? step : Math.max(step, (high - low) / 100);
    this.actions.slide(isovalue + by * width);
  }

  get state(): Omit<
    PanelState,
    "info" | "histogram" | "bytes" | "projection" | "canUndo" | "canRedo"
  > {
    return {
      isLogarithmic: this.#isLogarithmic,
      typed: this.#typed,
      isSweeping: this.#sweep.isRunning,
      sweepSeconds: this.#sweepSeconds,
      scale: this.#scale,
      surfaces: this.#surfaces,
      active: this.#active,
      look: this.#viewer.look,
      isThemeBackground: this.#isThemeBackground,
      clip: this.#viewer.clip,
      slices: this.#viewer.slices,
      show: this.#show,
    };
  }

  /** Shows what was shown before: undo and redo. */
  restore(
    view: Pick<
      AddressState,
      "surfaces" | "look" | "isThemeBackground" | "clip" | "slices" | "show"
    >,
  ): void {
    this.#sweep.stop();
    this.#active = Math.max(0, Math.min(this.#active, view.surfaces.length - 1));
    this.#show = view.show;
    this.#isThemeBackground = view.isThemeBackground;
    this.#viewer.setLook(view.look);
    this.#viewer.setClip(view.clip);
    this.#viewer.setSlices(view.slices);
    this.#setSurfaces(view.surfaces);
    this.themeChanged();
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

  readonly actions: Omit<
    PanelActions,
    | "lookAlong"
    | "fit"
    | "toggleProjection"
    | "undo"
    | "redo"
    | "saveTransparent"
    | "openCapture"
    | "saveSurface"
    | "showClipHandles"
  > = {
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
      this.#sweep.stop();
      this.#active = index;
      this.#changed();
    },
    changeSurface: (index, change) => this.#changeSurface(index, change),
    addSurface: () => {
      this.#sweep.stop();
      this.#active = this.#surfaces.length;
      this.#setSurfaces(withAddedSurface(this.#surfaces, this.#suggestions, this.#scale));
    },
    removeSurface: (index) => {
      this.#sweep.stop();
      const left = this.#surfaces.filter((_, i) => i !== index);
      const wasBefore = index < this.#active ? 1 : 0;
      this.#active = Math.min(this.#active - wasBefore, left.length - 1);
      this.#setSurfaces(left);
    },
    changeLook: (change) => {
      if (change.background !== undefined) this.#isThemeBackground = false;
      this.#changeLook(change);
    },
    turnLight: (right, up) =>
      this.#changeLook({ light: turnedLight(this.#viewer.look.light, right, up) }),
    followTheme: () => {
      this.#isThemeBackground = true;
      this.themeChanged();
    },
    toggleShown: (part) => {
      const show = new Set(this.#show);
      if (!show.delete(part)) show.add(part);
      this.#show = show;
      this.#changed();
    },
    changeClip: (clip) => this.#setClip(clip),
    cutAcrossView: () => {
      const { camera, info, clip } = this.#viewer;
      if (camera && info) this.#setClip({ ...clip, planes: [planeFacing(camera, info)] });
    },
    changeSlices: (slices) => {
      this.#viewer.setSlices(slices);
      this.#changed();
    },
    sliceAcrossView: () => {
      const { camera, info, slices } = this.#viewer;
      if (!camera || !info) return;
      this.actions.changeSlices({ ...slices, plane: planeFacing(camera, info) });
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

  #setSurfaces(surfaces: readonly Surface[]): void {
    this.#surfaces = surfaces;
    this.#viewer.setSurfaces(surfaces);
    this.#changed();
  }

  #changeSurface(index: number, change: Partial<Surface>): void {
    this.#setSurfaces(this.#surfaces.map((s, i) => (i === index ? { ...s, ...change } : s)));
  }

  #setIsovalue(isovalue: number): void {
    const { low, high } = this.#scale;
    const inside = Math.max(low, Math.min(high, isovalue));
    if (this.#surfaces[this.#active]?.isovalue === inside) this.#changed();
    else this.#changeSurface(this.#active, { isovalue: inside });
  }

  #setClip(clip: Clip): void {
    this.#viewer.setClip(clip);
    this.#changed();
  }

  #changeLook(change: Partial<Look>): void {
    this.#viewer.setLook(change);
    this.#changed();
  }
}
