import type { SceneSource } from "../scene/scene_source.ts";
import { BlobSource, type SlicedFile } from "../stream/blob_source.ts";
import { isDefaultClip, wholeVolume } from "../viewer/clipping.ts";
import { sameValue } from "../viewer/same_value.ts";
import { isDefaultSlices } from "../viewer/slices.ts";
import type { Camera } from "../viewer/types.ts";
import type { PickedSurface } from "./element_pick.ts";
import type { IsosplatViewerElement } from "./isosplat_viewer.ts";
import { showLayers } from "./notebook_layers.ts";
import {
  backgroundOf,
  cameraOf,
  clipOf,
  isovalueOf,
  layersOf,
  reportedTraits,
  showOf,
  slicesOf,
  stepOf,
  surfacesOf,
  type TraitName,
  type Traits,
  textOf,
  traitDefaults,
} from "./notebook_traits.ts";

/** The part of an AFM model that is used. */
export interface NotebookModel {
  get(name: string): unknown;
  /** If the value differs, calls the listeners of `change:name` at once. */
  set(name: string, value: unknown): void;
  /** Sends the changes to the kernel. */
  save_changes(): void;
  on(event: string, listener: () => void): void;
  off(event: string, listener: () => void): void;
}

/** The file behind an address that the browser cannot reach, read in another way. Undefined: it can be reached. */
export type FileOf = (address: string) => SlicedFile | undefined;

type Applier = (value: unknown) => void;

/**
 * Interval between two messages to the kernel. Views of the same model follow at once, without
 * messages.
 */
const saveIntervalMs = 100;

/**
 * Models to which a view is writing back the values that its element has derived. Other views do
 * not apply these values: each derives the same ones, and two views that differ in the last digit
 * would never stop.
 */
const writingBack = new WeakSet<NotebookModel>();

const viewEvents = ["isovaluechange", "camerachange", "clipchange", "sliceschange"] as const;

/**
 * One view of a model: an element whose properties are synchronized with the model's traits.
 *
 * Changes of the model are applied together, once all of them have arrived: a new `src` resets the
 * view, so it is applied before an isovalue that was set with it. Meanwhile nothing is written to
 * the model. Afterwards the values that the element has derived are written, if they differ. So a
 * value is not sent back to its origin.
 */
export class Notebook {
  readonly element: IsosplatViewerElement = document.createElement("isosplat-viewer");
  readonly #model: NotebookModel;
  readonly #listeners = new Map<string, () => void>();
  readonly #ended = new AbortController();
  readonly #changed = new Set<TraitName>();
  /**
   * Why values of the program could not be applied. They stay in the model, where the program finds
   * them, until the program sets others or a visitor changes the view.
   */
  readonly #refused = new Map<TraitName, string>();
  readonly #fileOf: FileOf;
  readonly #addresses = { src: "", scene: "" };
  #elementFault = "";
  /** The last step that the model had. */
  #receivedStep: number | null = null;
  #isApplying = false;
  #saveTimer = 0;

  constructor(model: NotebookModel, fileOf: FileOf = () => undefined) {
    this.#model = model;
    this.#fileOf = fileOf;
    for (const name of Object.keys(traitDefaults) as TraitName[]) {
      if (reportedTraits.includes(name)) continue;
      this.#changed.add(name);
      const listener = () => {
        if (writingBack.has(model)) return;
        if (this.#changed.size === 0) queueMicrotask(() => this.#apply());
        this.#changed.add(name);
      };
      model.on(`change:${name}`, listener);
      this.#listeners.set(`change:${name}`, listener);
    }
    this.#listen();
    this.#apply();
  }

  /** Removes the element, its WebGL context and every listener. Pending changes are still saved. */
  dispose(): void {
    if (this.#ended.signal.aborted) return;
    this.#ended.abort();
    for (const [event, listener] of this.#listeners) this.#model.off(event, listener);
    if (this.#saveTimer) this.#save();
    this.element.remove();
  }

  // ---- From the model to the element ----

  #apply(): void {
    if (this.#ended.signal.aborted) return;
    const changed = new Set(this.#changed);
    this.#changed.clear();
    this.#isApplying = true;
    try {
      for (const [name, apply] of Object.entries(this.#appliers) as [TraitName, Applier][]) {
        if (!changed.has(name)) continue;
        this.#refused.delete(name);
        try {
          apply(this.#model.get(name));
        } catch (error) {
          this.#refused.set(name, (error as Error).message);
        }
      }
    } finally {
      this.#isApplying = false;
    }
    writingBack.add(this.#model);
    try {
      this.#writeView();
    } finally {
      writingBack.delete(this.#model);
    }
    this.#writeFault();
  }

  /** In the order in which they are applied. */
  readonly #appliers: Partial<Record<TraitName, Applier>> = {
    controls: (value) => {
      this.element.controls = Boolean(value);
    },
    height: (value) => {
      this.element.style.blockSize = textOf("height", value);
      this.element.style.aspectRatio = this.element.style.blockSize ? "auto" : "";
    },
    background: (value) => this.#setAttribute("background", backgroundOf(value)),
    show: (value) => {
      this.element.show = showOf(value);
    },
    link: (value) => {
      this.element.link = textOf("link", value);
    },
    src: (value) => this.#setAddress("src", textOf("src", value)),
    scene: (value) => this.#setAddress("scene", textOf("scene", value)),
    layers: (value) => showLayers(this.element, layersOf(value)),
    step: (value) => {
      const step = stepOf(value);
      this.#receivedStep = step;
      if (step !== null && step !== this.element.step) this.element.step = step;
    },
    surfaces: (value) => {
      const surfaces = surfacesOf(value);
      if (surfaces.length > 0 && !sameValue(surfaces, this.element.surfaces)) {
        this.element.surfaces = surfaces;
      }
    },
    isovalue: (value) => {
      const isovalue = isovalueOf(value);
      const { isovalues } = this.element;
      if (isovalue !== null && isovalue !== isovalues[0]) {
        this.element.isovalues = [isovalue, ...isovalues.slice(1)];
      }
    },
    camera: (value) => {
      const present = this.#camera;
      const camera = cameraOf(value, present);
      if (camera && !sameValue(camera, present)) this.element.camera = camera;
    },
    clip: (value) => {
      const clip = clipOf(value) ?? wholeVolume;
      if (!sameValue(clip, this.element.clip)) this.element.clip = clip;
    },
    slices: (value) => {
      this.element.slices = slicesOf(value);
    },
  };

  /** Shows another volume or scene. */
  #setAddress(name: "src" | "scene", address: string): void {
    if (address === this.#addresses[name]) return;
    this.#addresses[name] = address;
    this.#elementFault = "";
    this.#write("volume", null);
    this.#write("time", null);
    this.#write("picked", null);
    this.#write("state", "");
    this.#write("complete", false);
    const file = this.#fileOf(address);
    if (file) this.#setFile(name, new BlobSource(file, "the kernel's file", false));
    else this.#setAttribute(name, address);
  }

  #setFile(name: "src" | "scene", file: BlobSource): void {
    if (name === "src") this.element.source = file;
    else this.element.sceneSource = { name: file.name, open: sceneOpener(file) };
  }

  #setAttribute(name: string, value: string): void {
    if (value) this.element.setAttribute(name, value);
    else this.element.removeAttribute(name);
  }

  // ---- From the element to the model ----

  #listen(): void {
    const { element } = this;
    const { signal } = this.#ended;
    element.addEventListener("opened", () => this.#onOpened(), { signal });
    element.addEventListener("progress", ({ detail }) => this.#onProgress(detail), { signal });
    element.addEventListener("fault", ({ detail }) => this.#onFault(detail.message), { signal });
    for (const event of viewEvents) {
      element.addEventListener(event, () => this.#writeView(), { signal });
    }
    element.addEventListener("stepchange", ({ detail }) => this.#onStep(detail), { signal });
    for (const event of ["pointerdown", "wheel", "keydown"]) {
      element.addEventListener(event, () => this.#takeOver(), { signal, passive: true });
    }
    element.addEventListener("pick", ({ detail }) => this.#onPick(detail), { signal });
  }

  #onOpened(): void {
    const { info } = this.element;
    if (!info) return;
    const { voxels, spacing, origin, range, metadata } = info;
    const suggested_isovalues = metadata.suggested_isovalues ?? [];
    this.#write("volume", { voxels, spacing, origin, range, suggested_isovalues });
    const { time } = this.element;
    this.#write("time", time && { values: time.values, unit: time.unit });
    this.#writeView();
    this.#onFault("");
  }

  /** A step of the model may be shown late: another view may have changed it by then. */
  #onStep(step: number): void {
    if (step !== this.#receivedStep || this.element.time?.isPlaying) this.#writeView();
  }

  #onFault(message: string): void {
    this.#elementFault = message;
    this.#writeFault();
  }

  /** A visitor has changed the view, which replaces the refused values. */
  #takeOver(): void {
    if (this.#refused.size === 0) return;
    this.#refused.clear();
    this.#writeView();
    this.#writeFault();
  }

  #onProgress({ state, complete, fault }: NonNullable<IsosplatViewerElement["progress"]>): void {
    this.#write("state", state);
    this.#write("complete", complete);
    this.#onFault(fault?.message ?? "");
  }

  /** The camera with its projection, which a camera of the element may lack. */
  get #camera(): Camera | null {
    const { camera } = this.element;
    return camera && { ...camera, projection: camera.projection ?? "perspective" };
  }

  /** Before a volume is open, unknown values stay as the program has set them. */
  #writeView(): void {
    const { surfaces, clip, slices } = this.element;
    const camera = this.#camera;
    const [first] = surfaces;
    if (first) {
      this.#write("isovalue", first.isovalue);
      this.#write("surfaces", surfaces);
    }
    if (camera) this.#write("camera", camera);
    if (this.element.time) this.#write("step", this.element.step);
    this.#write("clip", isDefaultClip(clip) ? null : clip);
    this.#write("slices", isDefaultSlices(slices) ? null : slices);
  }

  #writeFault(): void {
    const [refused] = this.#refused.values();
    this.#write("fault", refused ?? this.#elementFault);
  }

  #onPick({ position, voxel, normal, isovalue, name, label }: PickedSurface): void {
    this.#write("picked", { position, voxel, normal, isovalue, layer: name, label });
  }

  #write<K extends TraitName>(name: K, value: Traits[K]): void {
    if (this.#refused.has(name)) return;
    if (this.#isApplying && !reportedTraits.includes(name)) return;
    if (sameValue(this.#model.get(name) ?? null, value)) return;
    this.#model.set(name, value);
    this.#saveTimer ||= window.setTimeout(() => this.#save(), saveIntervalMs);
  }

  #save(): void {
    clearTimeout(this.#saveTimer);
    this.#saveTimer = 0;
    this.#model.save_changes();
  }
}

/** The code that reads scenes is loaded by the first one. */
function sceneOpener(file: BlobSource): SceneSource["open"] {
  return async (core, signal) =>
    (await import("../scene/scene_source.ts")).bundleScene(file).open(core, signal);
}
