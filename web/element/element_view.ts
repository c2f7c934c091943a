import type { StoreInfo } from "../core/types.ts";
import { wholeVolume } from "../viewer/clipping.ts";
import { sameValue } from "../viewer/same_value.ts";
import { writeCamera } from "../viewer/setting_text.ts";
import { noSlices } from "../viewer/slices.ts";
import { firstSurface } from "../viewer/surfaces.ts";
import type { Time } from "../viewer/time.ts";
import {
  type Camera,
  type Clip,
  defaultLook,
  type LookChange,
  type Slices,
  type Surface,
} from "../viewer/types.ts";
import type { Viewer } from "../viewer/viewer.ts";
import type { OpenOptions } from "../viewer/viewer_events.ts";
import { cameraOf, isovaluesOf, projectionOf, stepOf, surfacesOf } from "./element_attributes.ts";
import type { IsosplatViewerEvents } from "./element_events.ts";
import { ElementTime } from "./element_time.ts";
import { type Link, type LinkedElement, type LinkedView, sharedBy } from "./link_groups.ts";
import { groups } from "./page_resources.ts";

/** The functions that a view needs from its element. */
export interface ElementViewHost {
  /** Null while the element has no WebGL context. */
  viewer(): Viewer | null;
  /** The open volume; null before the first. */
  info(): StoreInfo | null;
  /** Whether the volume is being opened: changes at this time are the volume's defaults. */
  isOpening(): boolean;
  /** Requests a draw. */
  wake(): void;
  surfacesChanged(): void;
  clipChanged(): void;
  /** Null: the content does not change with time. */
  timeShown(time: Time | null): void;
}

/** What an element shows: the store of `src`, a scene, or only the layers of its child elements. */
export type ContentKind = "store" | "scene" | "layers";

/**
 * The view of an element: the surfaces of its first volume, the camera, clipping, slices and look of its
 * picture, and the step of its scene. Keeps them even without a viewer, passes them to the viewer, reports their
 * changes as events, and shares them with the group of the element.
 */
export class ElementView {
  readonly #element: HTMLElement;
  readonly #host: ElementViewHost;
  readonly #linked: LinkedElement = { receive: (view) => this.#receive(view) };
  readonly time: ElementTime;
  /** Whether the present change shows a default. */
  #isDefault = false;
  #isAttached = false;
  #link: Link | null = null;
  /** Not 0 while the viewer is being set to a view of the group, which must not be sent back. */
  #receiving = 0;
  /**
   * The values that attributes, calls, gestures or the group have set, without the volume's
   * defaults.
   */
  #chosen: LinkedView = {};
  /** Empty until the attribute, a call or the volume has isovalues. */
  #surfaces: readonly Surface[] = [];
  #camera: Camera | null = null;
  #clip: Clip = wholeVolume;
  #slices: Slices = noSlices;
  #look: LookChange = {};

  constructor(element: HTMLElement, host: ElementViewHost) {
    this.#element = element;
    this.#host = host;
    this.time = new ElementTime({
      viewer: () => host.viewer(),
      wake: () => host.wake(),
      shown: (time) => host.timeShown(time),
      changed: (step, time) =>
        this.#changed("stepchange", step, time === undefined ? {} : { time }),
    });
  }

  // ---- The surfaces of the volume ----

  get isovalues(): readonly number[] {
    return this.#surfaces.map(({ isovalue }) => isovalue);
  }
  set isovalues(requested: readonly number[] | null | undefined) {
    const defaults = surfacesOf(this.#element, requested ?? this.#firstIsovalues());
    this.surfaces = defaults.map((surface, i) => ({
      ...(this.#surfaces[i] ?? surface),
      isovalue: surface.isovalue,
    }));
  }

  get surfaces(): readonly Surface[] {
    return this.#surfaces;
  }
  set surfaces(requested: readonly Surface[] | null | undefined) {
    const before = this.isovalues;
    this.#surfaces = requested ? [...requested] : surfacesOf(this.#element, this.#firstIsovalues());
    this.#host.viewer()?.setSurfaces(this.#surfaces);
    this.#host.surfacesChanged();
    const { isovalues } = this;
    if (sameValue(isovalues, before)) return;
    this.#host.wake();
    this.#changed("isovaluechange", isovalues, { isovalues });
  }

  /** Moves the first surface, within the range of the volume. */
  moveFirst(isovalue: number): void {
    const [low, high] = this.#host.info()?.range ?? [isovalue, isovalue];
    const inside = Math.max(low, Math.min(high, isovalue));
    this.isovalues = [inside, ...this.isovalues.slice(1)];
    this.#host.surfacesChanged();
  }

  /** The first layer of the viewer has other surfaces, or another layer is the first one. */
  followSurfaces(viewer: Viewer): void {
    if (!sameValue(viewer.surfaces, this.#surfaces)) this.surfaces = viewer.surfaces;
  }

  /** Returns the isovalues of the attribute. Without it, the surfaces stay as they are. */
  readIsovalues(): readonly number[] | undefined {
    const isovalues = isovaluesOf(this.#element);
    if (isovalues) this.surfaces = surfacesOf(this.#element, isovalues);
    return isovalues;
  }

  /** The isovalues of the attribute, or those of the volume once it is open. */
  #firstIsovalues(): readonly number[] {
    const info = this.#host.info();
    return isovaluesOf(this.#element) ?? (info ? [firstSurface(info).isovalue] : []);
  }

  // ---- The picture ----

  get camera(): Camera | null {
    return this.#camera;
  }
  set camera(requested: Camera | null | undefined) {
    if (!requested) return;
    const before = projectionOf(this.#element);
    const camera = { ...requested, projection: requested.projection ?? before };
    this.#camera = camera;
    // The attribute follows the picture. The camera is set already, so the callback changes nothing.
    if (camera.projection !== before) this.#element.setAttribute("projection", camera.projection);
    this.#host.wake();
    const viewer = this.#host.viewer();
    if (viewer) viewer.setCamera(camera);
    else this.#changed("camerachange", camera, { camera });
  }

  /** The attribute of the projection has changed. */
  readProjection(): void {
    const projection = projectionOf(this.#element);
    const camera = this.#camera;
    if (camera && (camera.projection ?? "perspective") !== projection) {
      this.camera = { ...camera, projection };
    }
  }

  /** The viewer has moved its camera. */
  moved(camera: Camera): void {
    this.#camera = camera;
    this.#changed("camerachange", camera, { camera });
  }

  /** Shows all layers whole, as the default view: the group does not follow. */
  showWhole(viewer: Viewer): void {
    if (this.#chosen.camera || viewer.layers.length < 2) return;
    this.#isDefault = true;
    viewer.reset();
    this.#isDefault = false;
  }

  get clip(): Clip {
    return this.#clip;
  }
  set clip(requested: Clip | null | undefined) {
    const clip = requested ?? wholeVolume;
    this.#clip = clip;
    this.#host.viewer()?.setClip(clip);
    this.#host.clipChanged();
    this.#host.wake();
    this.#changed("clipchange", clip, { clip });
  }

  get slices(): Slices {
    return this.#slices;
  }
  set slices(requested: Slices | null | undefined) {
    const slices = requested ?? noSlices;
    if (sameValue(slices, this.#slices)) return;
    this.#slices = slices;
    this.#host.viewer()?.setSlices(slices);
    this.#host.wake();
    this.#changed("sliceschange", slices, { slices });
  }

  get look(): LookChange {
    return this.#look;
  }
  set look(change: LookChange | null | undefined) {
    this.#look = { ...this.#look, ...change };
    this.#host.viewer()?.setLook(this.#look);
    this.#host.wake();
  }

  // ---- Volumes ----

  /** Applies the view to a new viewer, in which no volume is open. */
  applyTo(viewer: Viewer): void {
    viewer.setLook(this.#look);
    viewer.setClip(this.#clip);
    viewer.setSlices(this.#slices);
    this.time.attach(viewer);
  }

  /** The clipping and the slices that were set, and take precedence over those of the scene. */
  get chosen(): Pick<LinkedView, "clip" | "slices"> {
    return this.#chosen;
  }

  /** The view in which a volume is opened. */
  get openOptions(): OpenOptions {
    return {
      ...(this.#surfaces.length > 0 && { surfaces: this.#surfaces }),
      ...(this.#camera && { camera: this.#camera }),
      projection: projectionOf(this.#element),
    };
  }

  /**
   * Called when the content is open. Values that were not set become those of the volume or of the scene;
   * values that were set meanwhile become the viewer's. Child elements have surfaces of their own.
   */
  opened(viewer: Viewer, kind: ContentKind): void {
    if (kind === "layers") this.#surfaces = viewer.surfaces;
    else if (this.#surfaces.length > 0) viewer.setSurfaces(this.#surfaces);
    else if (kind === "scene") this.surfaces = viewer.surfaces;
    else this.isovalues = viewer.surfaces.map(({ isovalue }) => isovalue);
    if (kind === "scene") this.#openedScene(viewer);
    const { camera } = viewer;
    if (!this.#camera) this.#camera = camera;
    else if (writeCamera(this.#camera) !== (camera && writeCamera(camera))) {
      viewer.setCamera(this.#camera);
    }
    // The group may have changed meanwhile, or lack the time of this scene.
    if (kind !== "store") this.#join();
  }

  /** Clipping and slices of a scene are those of the viewer already. */
  #openedScene(viewer: Viewer): void {
    if (!sameValue(viewer.clip, this.#clip)) {
      this.#clip = viewer.clip;
      this.#host.clipChanged();
      this.#changed("clipchange", viewer.clip, { clip: viewer.clip });
    }
    if (!sameValue(viewer.slices, this.#slices)) {
      this.#slices = viewer.slices;
      this.#changed("sliceschange", viewer.slices, { slices: viewer.slices });
    }
    const { chosenValue } = this.time;
    if (chosenValue !== undefined) this.#chosen.time = chosenValue;
  }

  /**
   * Another volume starts with the view of the attributes, of the group, or with its default view.
   */
  reset(): void {
    this.#leave();
    const camera = cameraOf(this.#element);
    this.#camera = camera ?? null;
    const isovalues = this.readIsovalues();
    if (!isovalues) this.#surfaces = [];
    // Isovalues and the range of slices are values of the previous volume.
    // Look, clipping and slices may be those of the previous scene.
    const { range, ...planes } = this.#chosen.slices ? this.#slices : noSlices;
    if (range || !sameValue(planes, this.#slices)) {
      this.#slices = planes;
      this.#host.viewer()?.setSlices(planes);
    }
    this.#host.viewer()?.setLook({ ...defaultLook, ...this.#look });
    const { clip } = this.#chosen;
    if (!clip && !sameValue(this.#clip, wholeVolume)) {
      this.#clip = wholeVolume;
      this.#host.viewer()?.setClip(wholeVolume);
      this.#host.clipChanged();
    }
    this.time.reset(stepOf(this.#element));
    const slices = this.#chosen.slices && this.#slices;
    this.#chosen = {
      ...(camera && { camera }),
      ...(isovalues && { isovalues }),
      ...(clip && { clip }),
      ...(slices && { slices }),
    };
    this.#join();
  }

  // ---- The group ----

  /** The element was added to a document, or removed. */
  setAttached(isAttached: boolean): void {
    this.#isAttached = isAttached;
    if (isAttached) this.#join();
    else this.#leave();
  }

  /** The attribute names another group, or other parts of the view. */
  relink(link: Link | null): void {
    this.#leave();
    this.#link = link;
    this.#join();
  }

  #leave(): void {
    if (this.#link) groups.leave(this.#link.group, this.#linked);
  }

  #join(): void {
    const link = this.#link;
    if (link && this.#isAttached) {
      this.#receive(groups.join(link.group, this.#linked, sharedBy(link, this.#chosen)));
    }
  }

  #receive(view: LinkedView): void {
    const { camera, isovalues, clip, slices, time } = this.#link ? sharedBy(this.#link, view) : {};
    this.#receiving++;
    try {
      if (camera) this.camera = camera;
      if (isovalues) this.isovalues = isovalues;
      if (clip) this.clip = clip;
      if (slices) this.slices = slices;
      if (time !== undefined) this.time.receive(time);
    } finally {
      this.#receiving--;
    }
  }

  /**
   * Reports a change to listeners. Also reports it to the group, unless it came from there or from
   * opening.
   */
  #changed<K extends keyof IsosplatViewerEvents>(
    name: K,
    detail: IsosplatViewerEvents[K]["detail"],
    view: LinkedView,
  ): void {
    if (!this.#host.isOpening() && !this.#isDefault) {
      Object.assign(this.#chosen, view);
      const link = this.#link;
      if (link && this.#receiving === 0) {
        groups.send(link.group, this.#linked, sharedBy(link, view));
      }
    }
    this.#element.dispatchEvent(new CustomEvent(name, { detail }));
  }
}
