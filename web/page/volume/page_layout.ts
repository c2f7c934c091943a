import { render } from "lit";
import type { Bins, StoreInfo } from "../../core/types.ts";
import { listed } from "../../texts/numbers.ts";
import { pageTexts } from "../../texts/page.ts";
import type { Viewer } from "../../viewer/viewer.ts";
import type { Target } from "../address/target.ts";
import type { DisplaySettings } from "../panel/display_settings.ts";
import { Histogram } from "../panel/histogram.ts";
import { isovalueChoices } from "../panel/isovalue_choices.ts";
import { IsovaluePictures } from "../panel/isovalue_pictures.ts";
import type { VolumeState } from "../panel/panel_state.ts";
import type { SurfaceSettings } from "../panel/surface_settings.ts";
import { formatValue } from "../shell/format.ts";
import type { Toast } from "../shell/toast.ts";
import type { LayersPart } from "./layers_part.ts";
import { LayoutPace } from "./layout_pace.ts";
import type { LoadedParts } from "./loaded_parts.ts";
import type { StatusLine } from "./status_line.ts";
import { bannerOf, type VolumeFaults } from "./volume_faults.ts";
import { type LayoutActions, type LayoutState, volumeLayout } from "./volume_layout.ts";

/** The data that the layout shows. */
export interface LaidOutPage {
  readonly viewer: Viewer;
  readonly surfaces: SurfaceSettings;
  readonly settings: DisplaySettings;
  readonly faults: VolumeFaults;
  readonly parts: LoadedParts;
  readonly layers: LayersPart;
  readonly status: StatusLine;
  readonly toast: Toast;
  readonly history: { canUndo: boolean; canRedo: boolean };
  readonly target: Target;
  /** The volume, once it is open. */
  readonly info: StoreInfo | null;
  /** Whether a surface has been drawn. */
  readonly hasPicture: boolean;
  readonly title: string;
  readonly actions: LayoutActions;
}

/** Lays out a volume page. Stores which of its parts are open. */
export class PageLayout {
  readonly #root: HTMLElement;
  readonly #page: LaidOutPage;
  readonly #histogram: Histogram;
  readonly #pictures = new IsovaluePictures({
    mayDraw: () => this.#showsRestingView(),
    changed: () => this.request(),
  });
  /** The bytes for an isovalue of a layer. `layer` is undefined if there is only one. */
  #cost: { layer: number | undefined; isovalue: number; bytes: number } | null = null;
  #fieldBins: { field: string; bins: Bins | undefined } | undefined;
  #tools: HTMLElement | null = null;
  #isSheetOpen = false;
  #isPanelHidden = false;
  /** On narrow screens, other parts are below the status line, which may have several lines of text. */
  readonly #statusSize = new ResizeObserver(() => {
    const { offsetHeight } = this.#page.status.element;
    this.#root.style.setProperty("--status-height", `${offsetHeight}px`);
  });
  readonly #pace = new LayoutPace(
    () => this.renderNow(),
    () => this.#showIsovalue(),
  );

  constructor(root: HTMLElement, page: LaidOutPage) {
    this.#root = root;
    this.#page = page;
    this.#histogram = new Histogram({
      pick: (value) => page.surfaces.actions.slide(value),
      activate: (index) => page.surfaces.actions.activate(index),
      step: (by) => page.surfaces.step(by, "step"),
    });
    this.#statusSize.observe(page.status.element);
  }

  /** Lays the page out in the next frame. `isIsovalueOnly`: see LayoutPace. */
  request(isIsovalueOnly = false): void {
    this.#pace.request(isIsovalueOnly);
  }

  /** Adds a button to the bar. */
  set tools(element: HTMLElement) {
    this.#tools = element;
    this.request();
  }

  themeChanged(): void {
    this.#histogram.draw();
    this.renderNow();
  }

  /** Another store is open, whose isovalues cost other bytes. */
  opened(): void {
    this.#cost = null;
    this.request();
  }

  /** The view has begun to change, or rests. */
  busyChanged(isBusy: boolean): void {
    if (isBusy) this.#pictures.stop();
    else this.rests();
  }

  /** The view rests. Computes the isovalue's bytes now, since this takes time in large volumes. */
  rests(): void {
    this.#updatePictures();
    this.#countField();
    const { surfaces, active } = this.#page.surfaces.state;
    const isovalue = surfaces[active]?.isovalue;
    if (isovalue === undefined || this.#bytesOf(isovalue) !== undefined) return;
    const { chosen } = this.#page.layers;
    const bytes = (chosen ?? this.#page.viewer).bytesOf(isovalue);
    if (bytes === undefined) return;
    this.#cost = { layer: chosen?.id, isovalue, bytes };
    this.request();
  }

  /** Only at rest, since this takes time in large volumes. */
  #countField(): void {
    const { look, fieldHistogram } = this.#page.viewer;
    if (look.colourBy !== "field") return;
    this.#fieldBins = { field: look.field.name, bins: fieldHistogram };
    this.request();
  }

  toggleSheet(): void {
    this.openSheet(!this.#isSheetOpen);
  }

  openSheet(isOpen: boolean): void {
    if (isOpen === this.#isSheetOpen) return;
    this.#isSheetOpen = isOpen;
    this.renderNow();
    // The focused element may now be hidden.
    if (!isOpen) this.#root.querySelector<HTMLElement>(".sheet-handle")?.focus();
  }

  togglePanel(): void {
    this.#isPanelHidden = !this.#isPanelHidden;
    this.request();
  }

  /**
   * Moves the focus after a surface was removed: the focused button is gone, or belongs to another
   * surface.
   */
  focusSurface(index: number): void {
    this.renderNow();
    const rows = this.#root.querySelectorAll<HTMLElement>(".surface-value");
    rows[Math.min(index, rows.length - 1)]?.focus();
  }

  renderNow(): void {
    this.#pace.laidOut();
    const { viewer, parts, title } = this.#page;
    const { surfaces } = this.#page;
    const isovalues = listed(surfaces.first.map(({ isovalue }) => formatValue(isovalue)));
    viewer.canvas.setAttribute("aria-label", pageTexts.picture(title, isovalues));
    parts.overlay?.show(this.#page.settings.state.show);
    parts.clipHandles?.request();
    this.#page.layers.refresh();
    render(volumeLayout(this.#state(), this.#page.actions), this.#root);
    this.#showHistogram();
    this.#updatePictures();
  }

  close(): void {
    this.#pictures.close();
    this.#statusSize.disconnect();
    this.#root.style.removeProperty("--status-height");
  }

  /** Whether the view is complete and rests, and the pictures of isovalues are in view. */
  #showsRestingView(): boolean {
    const { viewer } = this.#page;
    const { state } = viewer.progress ?? {};
    const isComplete = state === "complete" || state === "limited";
    if (viewer.isBusy || !isComplete || document.hidden) return false;
    const picture = this.#root.querySelector(".choice-picture");
    if (!picture?.checkVisibility()) return false;
    const { top, bottom } = picture.getBoundingClientRect();
    return top < innerHeight && bottom > 0;
  }

  #updatePictures(): void {
    const { viewer, layers, target } = this.#page;
    const { chosen } = layers;
    const info = this.#chosenInfo;
    // The pictures of a provisional store would soon be replaced.
    if (!info || target.provisional) this.#pictures.update(null);
    else {
      const isovalues = isovalueChoices(info).map(({ isovalue }) => isovalue);
      const access = () => (chosen ?? viewer).storeAccess;
      this.#pictures.update({ info, isovalues, access });
    }
  }

  /** The store on which isovalue and surfaces act. */
  get #chosenInfo(): StoreInfo | null {
    const { layers, info } = this.#page;
    return layers.chosen ? layers.chosen.info : info;
  }

  #offered(): VolumeState["offered"] {
    const info = this.#chosenInfo;
    const choices = info ? isovalueChoices(info) : [];
    const isovalues = choices.map(({ isovalue }) => isovalue);
    if (!info || !this.#pictures.arePossible(info, isovalues)) return { choices, pictures: null };
    return { choices, pictures: isovalues.map((each) => this.#pictures.pictureOf(info, each)) };
  }

  /** Shows the isovalue of the active surface in the histogram, the field and the slider. */
  #showIsovalue(): void {
    const { surfaces, active, typed } = this.#page.surfaces.state;
    const isovalue = surfaces[active]?.isovalue;
    if (isovalue === undefined) return;
    const field = this.#root.querySelector<HTMLInputElement>(".isovalue-field");
    const slider = this.#root.querySelector<HTMLInputElement>(".isovalue-slider");
    if (field && typed === undefined) field.value = formatValue(isovalue);
    if (slider) slider.valueAsNumber = isovalue;
    this.#showHistogram();
  }

  #showHistogram(): void {
    const { surfaces } = this.#page;
    const values = this.#chosenInfo;
    if (!values) return;
    const { scale, isLogarithmic } = surfaces.state;
    const { suggestions, marks } = surfaces;
    const { histogram, active_cells: activeCells } = values.metadata;
    this.#histogram.show({ scale, suggestions, histogram, activeCells, isLogarithmic }, marks);
  }

  #state(): LayoutState {
    const { viewer, faults, parts, layers, status, toast, target, info, hasPicture } = this.#page;
    const { chosen } = layers;
    const surfaces = this.#page.surfaces.state;
    const settings = this.#page.settings.state;
    const fault = faults.current(target.name);
    const isClipBoxShown = parts.isClipBoxShown && !this.#isPanelHidden;
    return {
      title: this.#page.title,
      provisional: target.provisional,
      tools: this.#tools,
      panel: info && {
        info,
        projection: viewer.camera?.projection,
        fieldBins:
          settings.look.colourBy === "field" && this.#fieldBins?.field === settings.look.field.name
            ? this.#fieldBins.bins
            : undefined,
        hasLabels: viewer.legend?.categories !== undefined,
        mayEnterSpacing: !layers.scene && !chosen,
        canUndo: this.#page.history.canUndo,
        canRedo: this.#page.history.canRedo,
        histogram: this.#histogram.element,
        offered: this.#offered(),
        bytes: this.#bytesOf(surfaces.surfaces[surfaces.active]?.isovalue),
        ...surfaces,
        ...settings,
      },
      background: settings.look.background,
      // If there is no picture, the error is shown instead.
      problem: faults.problem ?? (hasPicture ? null : fault),
      others: faults.others,
      legend: viewer.legend,
      banner: hasPicture ? bannerOf(fault) : null,
      toast: toast.message,
      announced: this.#page.surfaces.announced,
      isOpening: !hasPicture && !faults.isSettled,
      isSheetOpen: this.#isSheetOpen,
      isPanelHidden: this.#isPanelHidden,
      canvas: viewer.canvas,
      overlay: parts.overlay?.element ?? null,
      clipHandles: isClipBoxShown ? (parts.clipHandles?.element ?? null) : null,
      measure: parts.measureParts(info),
      layersSection: layers.element,
      isOfSeveral: layers.isOpen,
      chosen: chosen ? { title: layers.titleOf(chosen), info: chosen.info } : null,
      slicesSection: parts.slicesSection,
      timeBar: parts.time.element,
      status: status.element,
    };
  }

  #bytesOf(isovalue: number | undefined): number | undefined {
    const isSame = this.#cost?.layer === this.#page.layers.chosen?.id;
    return isSame && this.#cost?.isovalue === isovalue ? this.#cost?.bytes : undefined;
  }
}
