import type { StoreInfo } from "../../core/types.ts";
import type { Measurement } from "../../measure/measurement.ts";
import type { ClipHandles } from "../../overlay/clip_handles.ts";
import type { Overlay } from "../../overlay/overlay.ts";
import type { ShownScene } from "../../scene/open_scene.ts";
import { pageTexts } from "../../texts/page.ts";
import type { AxisView } from "../../viewer/camera_views.ts";
import type { Clip } from "../../viewer/types.ts";
import type { Viewer } from "../../viewer/viewer.ts";
import { keptSessionKey, type UrlState } from "../address/url_state.ts";
import type { Measure, MeasureHost } from "../measure/measure.ts";
import { loadPart } from "../shell/load_part.ts";
import { PageTime } from "../time/page_time.ts";
import type { PagePick } from "./page_pick.ts";
import type { LayoutState } from "./volume_layout.ts";

/** The functions that the parts need from their page. */
export interface LoadedPartsHost extends MeasureHost {
  /** The title of the page. */
  title(): string;
  /** Names something in the picture. */
  names(text: string): void;
  lookAlong(view: AxisView): void;
  changeClip(clip: Clip): void;
}

/** The parts of a volume page that are loaded after the first surface, or at their first use. */
export class LoadedParts {
  readonly #viewer: Viewer;
  readonly #url: UrlState;
  readonly #search: string;
  readonly #host: LoadedPartsHost;
  #overlay: Overlay | null = null;
  #clipHandles: ClipHandles | null = null;
  #isClipBoxShown = false;
  #pick: PagePick | null = null;
  #measure: Measure | null = null;
  #loadingMeasure: Promise<void> | null = null;
  #slicesSection: LayoutState["slicesSection"] = null;
  /** The measurements of the scene that is open. */
  #ofScene: readonly Measurement[] = [];
  readonly time: PageTime;

  /** `search`: the query of the address when the page was opened, from which `url` was parsed. */
  constructor(viewer: Viewer, url: UrlState, search: string, host: LoadedPartsHost) {
    this.#viewer = viewer;
    this.#url = url;
    this.#search = search;
    this.#host = host;
    this.time = new PageTime(viewer, url.time, host);
  }

  get overlay(): Overlay | null {
    return this.#overlay;
  }

  get clipHandles(): ClipHandles | null {
    return this.#clipHandles;
  }

  /** Whether the visitor wants the clip box. */
  get isClipBoxShown(): boolean {
    return this.#isClipBoxShown;
  }

  /** The measurements; null until they are loaded. */
  get measure(): Measure | null {
    return this.#measure;
  }

  get slicesSection(): LayoutState["slicesSection"] {
    return this.#slicesSection;
  }

  /** See AddressState.measures. */
  get measures(): readonly string[] | null {
    return this.#measure ? this.#measure.lines : (this.#url.measures ?? null);
  }

  /** The present measurements. Loads their code if it is needed for this. */
  async measurements(): Promise<readonly Measurement[]> {
    if (this.#hasMeasurements) await this.loadMeasure();
    return this.#measure?.tool.measurements ?? this.#ofScene;
  }

  /** Call it when the page has opened a scene, or a store (null). */
  opened(scene: Pick<ShownScene, "document"> | null): void {
    this.#ofScene = scene?.document.measurements ?? [];
    if (this.#overlay && this.#hasMeasurements) void this.loadMeasure();
  }

  get #hasMeasurements(): boolean {
    const { measures } = this.#url;
    return (measures ?? this.#ofScene).length > 0 || hasKeptSession();
  }

  /** The elements for the measurements of an open volume. */
  measureParts(info: StoreInfo | null): LayoutState["measure"] {
    const measure = this.#measure;
    return measure && info && { element: measure.element, section: measure.section(info) };
  }

  /** Loads the overlays above the picture, after the first surface. */
  async loadOverlay(): Promise<void> {
    const [{ Overlay }, { PagePick }] = await loadPart(() =>
      Promise.all([import("../../overlay/overlay.ts"), import("./page_pick.ts")]),
    );
    this.#pick = new PagePick(this.#viewer, {
      isMeasuring: () => Boolean(this.#measure?.tool.kind),
      titleOfHit: (layer) => this.#host.titleOfHit(layer),
      title: () => this.#host.title(),
      show: (text) => this.#host.names(text),
    });
    this.#overlay = new Overlay(this.#viewer, (view) => this.#host.lookAlong(view));
    this.#host.render();
    if (this.#hasMeasurements) await this.loadMeasure();
  }

  /** Names the layer in the middle of the picture. */
  nameMiddle(): void {
    this.#pick?.nameMiddle();
  }

  /** Loads the handles at their first use. */
  async showClipHandles(isShown: boolean): Promise<void> {
    this.#isClipBoxShown = isShown;
    this.#host.render();
    if (!isShown || this.#clipHandles) return;
    try {
      const { ClipHandles } = await import("../../overlay/clip_handles.ts");
      this.#clipHandles ??= new ClipHandles(this.#viewer, (clip) => this.#host.changeClip(clip));
      this.#host.render();
    } catch {
      this.#host.note(pageTexts.noHandles);
    }
  }

  async loadSlices(): Promise<void> {
    if (this.#slicesSection) return;
    try {
      this.#slicesSection = (await import("../panel/slices_section.ts")).slicesSection;
      this.#host.render();
    } catch {
      this.#host.note(pageTexts.noSection);
    }
  }

  /** Loads the measurements at their first use, or if the address has some. */
  loadMeasure(): Promise<void> {
    this.#loadingMeasure ??= import("../measure/measure.ts").then(
      ({ Measure }) => {
        this.#measure = new Measure(
          this.#viewer,
          this.#host,
          this.#url.measures,
          this.#ofScene,
          this.#search,
        );
        this.#host.render();
      },
      () => {
        this.#loadingMeasure = null;
        this.#host.note(pageTexts.noMeasuring);
      },
    );
    return this.#loadingMeasure;
  }

  /** The address was written. If it lacks measurements or layers, the session is kept in this tab. */
  rested(isWhole: boolean): void {
    if (this.#measure || isWhole) this.#measure?.rested(isWhole);
    else void this.loadMeasure().then(() => this.#measure?.rested(false));
  }

  /** Begins or ends measuring distances. */
  async beginMeasuring(): Promise<void> {
    await this.loadMeasure();
    const tool = this.#measure?.tool;
    tool?.choose(tool.kind ?? "distance");
  }
}

/** Whether a session belongs to the address: see open_session.ts. */
function hasKeptSession(): boolean {
  try {
    return sessionStorage.getItem(keptSessionKey) !== null;
  } catch {
    return false; // storage may be disabled
  }
}
