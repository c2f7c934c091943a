import { render } from "lit";
import { type Source, type StoreInfo, StreamError } from "../stream/index.ts";
import {
  type Camera,
  type ClipBox,
  defaultLook,
  handleCameraKey,
  type Look,
  type Surface,
  type ViewError,
  Viewer,
  wholeVolume,
} from "../viewer/index.ts";
import { formatValue } from "./format.ts";
import { showHelp } from "./help.ts";
import { drawHistogram, valueAt } from "./histogram.ts";
import { fallbackIsovalue, type IsovalueScale, isovalueScale, snapped } from "./isovalue_scale.ts";
import type { PanelState } from "./panel.ts";
import { type Problem, problemOf } from "./problems.ts";
import { StatusLine } from "./status_line.ts";
import { surfacesAt, withAddedSurface } from "./surfaces.ts";
import { onTheme, theme, toggleTheme } from "./theme.ts";
import { keepThumbnail } from "./thumbnails.ts";
import { readUrl, type UrlState } from "./url_state.ts";
import { AddressBar } from "./view_address.ts";
import {
  type Banner,
  type LayoutActions,
  type LayoutState,
  volumeLayout,
} from "./volume_layout.ts";
import { fetchVolumes } from "./volumes_api.ts";

const themeBackground = { light: "#eef0f3", dark: "#15181d" };
const toastMs = 2500;

const offlineBanner: Banner = {
  text: "The server does not answer. What is here stays; the rest is tried again.",
  isWaiting: true,
};
const contextLostBanner: Banner = {
  text: "The browser took the graphics card away. Waiting to get it back.",
  isWaiting: true,
};

export interface Target {
  /** The volume's name or the store's address. */
  name: string;
  source: () => Source;
}

/** One volume: its picture, and everything that changes it. Owns the viewer and the address. */
export class VolumePage {
  readonly #root: HTMLElement;
  readonly #target: Target;
  readonly #canvas = document.createElement("canvas");
  readonly #status = new StatusLine();
  readonly #viewer: Viewer;
  readonly #url: UrlState;

  #info: StoreInfo | null = null;
  #scale: IsovalueScale = { low: 0, high: 1, step: 0.01 };
  #surfaces: Surface[] = [];
  #active = 0;
  #look: Look;
  #isThemeBackground: boolean;
  #clip: ClipBox;
  #camera: Camera | null = null;

  #problem: Problem | null = null;
  #names: string[] = [];
  #banner: Banner | null = null;
  #toast = "";
  #toastTimer = 0;
  #isSheetOpen = false;
  #isPanelHidden = false;
  #hasPicture = false;
  #keptThumbnail = "";
  #renderHandle = 0;
  readonly #address = new AddressBar(() =>
    this.#info
      ? {
          volume: this.#url.volume,
          src: this.#url.src,
          surfaces: this.#surfaces,
          look: this.#look,
          isThemeBackground: this.#isThemeBackground,
          clip: this.#clip,
          camera: this.#camera ?? this.#url.camera,
        }
      : null,
  );

  /** Resolves when there is something to see: a surface, or what went wrong. */
  readonly firstSight: Promise<void>;
  #seen = () => {};

  constructor(root: HTMLElement, target: Target) {
    this.#root = root;
    this.#target = target;
    this.#url = readUrl(location.search);
    this.#isThemeBackground = this.#url.background === undefined;
    this.#look = {
      kind: this.#url.kind ?? defaultLook.kind,
      colourBy: this.#url.colourBy ?? defaultLook.colourBy,
      colourMap: this.#url.colourMap ?? defaultLook.colourMap,
      eyeDome: this.#url.eyeDome ?? defaultLook.eyeDome,
      background: this.#url.background ?? themeBackground[theme()],
    };
    this.#clip = this.#url.clip ?? wholeVolume;

    this.#canvas.className = "view";
    this.#canvas.id = "view";
    this.#canvas.tabIndex = 0;
    this.#canvas.setAttribute("role", "application");
    this.#canvas.setAttribute("aria-roledescription", "3D view");
    this.#viewer = new Viewer(this.#canvas);
    this.#listen();
    this.#renderNow();
    this.firstSight = new Promise((resolve) => {
      this.#seen = resolve;
    });
    void this.#open();
  }

  #listen(): void {
    const viewer = this.#viewer;
    viewer.on("progress", (progress) => {
      this.#status.progress(progress);
      if (progress.state === "offline") this.#showBanner(offlineBanner);
      else if (this.#banner === offlineBanner) this.#showBanner(null);
      if (progress.complete) this.#keepThumbnail();
    });
    viewer.on("frame", (frame) => {
      this.#status.frame(frame);
      if (!this.#hasPicture && frame.samplesDrawn > 0) {
        this.#hasPicture = true;
        this.#seen();
        this.#render();
      }
    });
    viewer.on("camera", (camera) => {
      this.#camera = camera;
      this.#address.changed();
    });
    viewer.on("error", (error) => {
      this.#failed(error);
    });
    viewer.on("context", (state) => {
      this.#showBanner(state === "lost" ? contextLostBanner : null);
    });
    onTheme(() => {
      if (this.#isThemeBackground) this.#setBackground(themeBackground[theme()]);
      this.#renderNow();
    });
    window.addEventListener("keydown", (event) => this.#onKey(event));
    window.addEventListener("resize", () => this.#render());
  }

  async #open(): Promise<void> {
    this.#problem = null;
    this.#banner = null;
    this.#hasPicture = false;
    this.#status.clear();
    document.title = `${this.#target.name} · Isosplat`;
    this.#render();
    const { isovalues } = this.#url;
    if (this.#surfaces.length === 0 && isovalues)
      this.#surfaces = surfacesAt(isovalues, this.#url.colours, this.#url.opacities);
    this.#viewer.setLook(this.#look);
    this.#viewer.setClip(this.#clip);
    try {
      const camera = this.#camera ?? this.#url.camera;
      const info = await this.#viewer.open(this.#target.source(), {
        ...(this.#surfaces.length > 0 ? { surfaces: this.#surfaces } : {}),
        ...(camera ? { camera } : {}),
      });
      this.#opened(info);
    } catch (error) {
      if (error instanceof DOMException && error.name === "AbortError") return;
      this.#fail(error);
    }
  }

  #opened(info: StoreInfo): void {
    this.#info = info;
    this.#problem = null;
    this.#scale = isovalueScale(info.range, info.mapping.scale);
    document.title = `${this.#title()} · Isosplat`;
    if (this.#surfaces.length === 0) {
      const first = info.metadata.suggested_isovalues?.[0] ?? fallbackIsovalue(this.#scale);
      this.#surfaces = surfacesAt([first], this.#url.colours, this.#url.opacities);
      this.#viewer.setSurfaces(this.#surfaces);
    }
    this.#address.changed();
    this.#render();
  }

  #title(): string {
    return this.#info?.metadata.title || this.#info?.metadata.name || this.#target.name;
  }

  /** An error that the viewer tells of while it goes on. */
  #failed(error: StreamError | ViewError): void {
    const isOpen = this.#info !== null;
    if (error instanceof StreamError && error.retrying) {
      // Once open, progress says so; before, there is nothing else to see.
      if (!isOpen) this.#fail(error);
    } else if (error instanceof StreamError && isOpen) {
      // What is drawn stays: the message goes beside it.
      // Its head was read, so it is a store: what cannot be read now is damaged.
      const kind = error.kind === "bad-store" ? "corrupt" : error.kind;
      const { title, text } = problemOf(new StreamError(kind, error.message), this.#target.name);
      this.#showBanner({ text: `${title}. ${text}`, detail: error.message, isWaiting: false });
    } else {
      this.#fail(error);
    }
  }

  #showBanner(banner: Banner | null): void {
    if (banner === this.#banner) return;
    this.#banner = banner;
    this.#render();
  }

  #fail(error: unknown): void {
    this.#seen();
    this.#problem = problemOf(error, this.#target.name);
    this.#render();
    if (error instanceof StreamError && error.kind === "not-found" && this.#url.volume) {
      fetchVolumes()
        .then((volumes) => {
          this.#names = volumes.filter((volume) => !volume.error).map((volume) => volume.name);
          this.#render();
        })
        .catch(() => {}); // the message stands without the list
    }
  }

  // ---- What the controls do ----

  #setSurfaces(surfaces: Surface[]): void {
    this.#surfaces = surfaces;
    this.#viewer.setSurfaces(surfaces);
    this.#address.changed();
    this.#render();
  }

  #changeSurface(index: number, change: Partial<Surface>): void {
    this.#setSurfaces(this.#surfaces.map((s, i) => (i === index ? { ...s, ...change } : s)));
  }

  #setIsovalue(isovalue: number): void {
    const { low, high } = this.#scale;
    const inside = Math.max(low, Math.min(high, isovalue));
    if (this.#surfaces[this.#active]?.isovalue === inside) this.#render();
    else this.#changeSurface(this.#active, { isovalue: inside });
  }

  #setBackground(background: string): void {
    this.#changeLook({ background });
  }

  #changeLook(change: Partial<Look>): void {
    this.#look = { ...this.#look, ...change };
    this.#viewer.setLook(change);
    this.#address.changed();
    this.#render();
  }

  readonly #actions: LayoutActions = {
    retry: () => void this.#open(),
    reset: () => this.#viewer.reset(),
    savePicture: () => void this.#saveScreenshot(),
    copyLink: () => void this.#copyLink(),
    toggleSheet: () => {
      this.#isSheetOpen = !this.#isSheetOpen;
      this.#render();
    },
    slide: (value) => this.#setIsovalue(snapped(value, this.#scale)),
    enter: (value) => this.#setIsovalue(value),
    activate: (index) => {
      this.#active = index;
      this.#render();
    },
    changeSurface: (index, change) => this.#changeSurface(index, change),
    addSurface: () => {
      const suggestions = this.#info?.metadata.suggested_isovalues ?? [];
      this.#active = this.#surfaces.length;
      this.#setSurfaces(withAddedSurface(this.#surfaces, suggestions, this.#scale));
    },
    removeSurface: (index) => {
      const left = this.#surfaces.filter((_, i) => i !== index);
      const wasBefore = index < this.#active ? 1 : 0;
      this.#active = Math.min(this.#active - wasBefore, left.length - 1);
      this.#setSurfaces(left);
    },
    changeLook: (change) => {
      if (change.background !== undefined) this.#isThemeBackground = false;
      this.#changeLook(change);
    },
    followTheme: () => {
      this.#isThemeBackground = true;
      this.#setBackground(themeBackground[theme()]);
    },
    changeClip: (clip) => {
      this.#clip = clip;
      this.#viewer.setClip(clip);
      this.#address.changed();
      this.#render();
    },
    histogramPointer: (event) => this.#histogramPointer(event),
  };

  #histogramPointer(event: PointerEvent): void {
    const canvas = event.currentTarget as HTMLElement;
    if (event.type === "pointerdown" && event.button === 0)
      canvas.setPointerCapture(event.pointerId);
    if (!canvas.hasPointerCapture(event.pointerId)) return;
    this.#setIsovalue(snapped(valueAt(event.offsetX, canvas, this.#scale), this.#scale));
  }

  #onKey(event: KeyboardEvent): void {
    if (event.defaultPrevented || event.ctrlKey || event.metaKey || event.altKey) return;
    if (document.querySelector("wa-dialog[open]")) return;
    const focus = focusOf(event, this.#canvas);
    if (focus === "text") return;
    if (focus === "none" && handleCameraKey(event, this.#viewer)) {
      event.preventDefault();
      return;
    }
    const { low, high, step } = this.#scale;
    const coarse = Math.max(step, (high - low) / 100);
    const keys: Record<string, () => void> = {
      "[": () => this.#step(-coarse),
      "]": () => this.#step(coarse),
      "{": () => this.#step(-step),
      "}": () => this.#step(step),
      "?": showHelp,
      c: () => void this.#copyLink(),
      s: () => void this.#saveScreenshot(),
      t: toggleTheme,
      f: () => this.#togglePanel(),
      r: () => this.#viewer.reset(),
    };
    const action = keys[event.key];
    if (action) {
      action();
      event.preventDefault();
    }
  }

  #step(by: number): void {
    const isovalue = this.#surfaces[this.#active]?.isovalue;
    if (isovalue !== undefined) this.#setIsovalue(snapped(isovalue + by, this.#scale));
  }

  #togglePanel(): void {
    this.#isPanelHidden = !this.#isPanelHidden;
    this.#render();
  }

  async #copyLink(): Promise<void> {
    this.#address.write();
    try {
      await navigator.clipboard.writeText(location.href);
      this.#say("Link copied");
    } catch {
      this.#say("The browser keeps the clipboard to itself: copy the address bar instead");
    }
  }

  async #saveScreenshot(): Promise<void> {
    try {
      const link = document.createElement("a");
      link.href = URL.createObjectURL(await this.#viewer.screenshot());
      const isovalues = this.#surfaces.map((surface) => formatValue(surface.isovalue)).join("-");
      link.download = `${this.#title().replace(/[^\w.-]+/g, "-")}-${isovalues}.png`;
      link.click();
      setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
      this.#say("Picture saved");
    } catch (error) {
      this.#say(error instanceof Error ? error.message : "There is no picture yet");
    }
  }

  #keepThumbnail(): void {
    const id = this.#info?.contentId;
    if (!id || this.#keptThumbnail === id || !this.#hasPicture) return;
    this.#keptThumbnail = id;
    const keep = () =>
      this.#viewer
        .screenshot()
        .then((picture) => keepThumbnail(id, picture))
        .catch(() => {}); // the card shows the histogram instead
    // When nothing else is to be done; Safari has no idle callback.
    if ("requestIdleCallback" in window) requestIdleCallback(keep, { timeout: 5000 });
    else setTimeout(keep, 1000);
  }

  #say(toast: string): void {
    this.#toast = toast;
    clearTimeout(this.#toastTimer);
    this.#toastTimer = window.setTimeout(() => {
      this.#toast = "";
      this.#render();
    }, toastMs);
    this.#render();
  }

  // ---- The page ----

  #render(): void {
    if (this.#renderHandle === 0) {
      this.#renderHandle = requestAnimationFrame(() => this.#renderNow());
    }
  }

  #renderNow(): void {
    cancelAnimationFrame(this.#renderHandle);
    this.#renderHandle = 0;
    const info = this.#info;
    const isovalues = this.#surfaces.map((surface) => formatValue(surface.isovalue)).join(", ");
    this.#canvas.setAttribute(
      "aria-label",
      `Isosurface of ${this.#title()} at ${isovalues}. Arrow keys turn it, plus and minus zoom.`,
    );
    const layout: LayoutState = {
      title: this.#title(),
      panel: info ? this.#panelState(info) : null,
      background: this.#look.background,
      problem: this.#problem,
      names: this.#names,
      banner: this.#banner,
      toast: this.#toast,
      hasPicture: this.#hasPicture,
      isSheetOpen: this.#isSheetOpen,
      isPanelHidden: this.#isPanelHidden,
      canvas: this.#canvas,
      status: this.#status.element,
    };
    render(volumeLayout(layout, this.#actions), this.#root);
    this.#drawHistogram();
  }

  #panelState(info: StoreInfo): PanelState {
    return {
      info,
      scale: this.#scale,
      surfaces: this.#surfaces,
      active: this.#active,
      look: this.#look,
      isThemeBackground: this.#isThemeBackground,
      clip: this.#clip,
    };
  }

  #drawHistogram(): void {
    const canvas = this.#root.querySelector<HTMLCanvasElement>("#histogram");
    if (!canvas || !this.#info) return;
    drawHistogram(canvas, {
      scale: this.#scale,
      histogram: this.#info.metadata.histogram,
      suggestions: this.#info.metadata.suggested_isovalues ?? [],
      marks: this.#surfaces.map((surface, i) => ({
        value: surface.isovalue,
        colour: surface.colour,
        isActive: i === this.#active,
      })),
    });
  }
}

/** What a key would go to: text fields take all keys, other controls some, the page the rest. */
function focusOf(event: KeyboardEvent, canvas: HTMLElement): "text" | "control" | "none" {
  const origin = event.composedPath()[0];
  if (!(origin instanceof HTMLElement) || origin === document.body || origin === canvas)
    return "none";
  const isField = origin.matches("input, textarea, select, [role=combobox], [role=listbox]");
  if ((isField && !origin.matches("[type=color]")) || origin.isContentEditable) return "text";
  return "control";
}
