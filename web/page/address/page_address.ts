import type { Triple } from "../../core/types.ts";
import type { Measurement } from "../../measure/measurement.ts";
import { defaultParts, type OverlayPart, overlayParts } from "../../overlay/parts.ts";
import { sameValue } from "../../viewer/same_value.ts";
import { surfaceColours } from "../../viewer/surfaces.ts";
import type { Camera, Clip, Look, Slices, Surface } from "../../viewer/types.ts";
import { type LayersView, layersAddress } from "./layer_address.ts";
import type { UnitSpacing } from "./spacing_units.ts";
import { longestQuery, type UrlState, writeUrl } from "./url_state.ts";

/**
 * The address is written after this time without changes (ms). Writing it takes browser time that
 * gestures need, and browsers limit it to about 100 calls in 30 s.
 */
const restMs = 300;

/** The picture that the address opens without parameters: the page's defaults, and what its scene states. */
export interface OpenedPicture {
  look: Look;
  /** Whether the background follows the theme. */
  isThemeBackground: boolean;
  clip: Clip;
  slices: Slices;
}

export interface AddressState {
  volume: string | undefined;
  scene: string | undefined;
  src: string | undefined;
  /** Undefined if it is that of the volume's file. */
  spacing: Triple | undefined;
  /** Not in the address: what is kept on the device for other visits, for undo. */
  keptSpacing?: UnitSpacing | undefined;
  surfaces: readonly Surface[];
  look: Look;
  isThemeBackground: boolean;
  clip: Clip;
  slices: Slices;
  opened: OpenedPicture;
  show: ReadonlySet<OverlayPart>;
  /** The value of the step that is shown; undefined for the first one, or without steps. */
  time: number | undefined;
  camera: Camera | undefined;
  /**
   * Whether the camera is the default, which depends on the window and is not written to the
   * address.
   */
  isDefaultCamera: boolean;
  /** Null if they are those of the scene, or if there are none. */
  measures: readonly string[] | null;
  /** All measurements with what the address has no space for, for undo; null until they are loaded. */
  measurements: readonly Measurement[] | null;
  /** Null if there is only the page's volume, with its default settings. */
  layers: LayersView | null;
}

/** The address of a view. It contains only the settings that differ from those with which the page opens. */
export function addressOf(view: AddressState): UrlState {
  const { surfaces, look, clip, slices, opened } = view;
  const state: UrlState = { isovalues: surfaces.map((surface) => surface.isovalue) };
  if (view.volume) state.volume = view.volume;
  else if (view.scene) state.scene = view.scene;
  else if (view.src) state.src = view.src;
  if (view.spacing) state.spacing = view.spacing;
  if (surfaces.some((surface, i) => surface.colour !== surfaceColours[i])) {
    state.colours = surfaces.map((surface) => surface.colour);
  }
  if (surfaces.some((surface) => surface.opacity !== 1)) {
    state.opacities = surfaces.map((surface) => surface.opacity);
  }
  if (view.camera) {
    const { projection, ...camera } = view.camera;
    if (!view.isDefaultCamera) state.camera = camera;
    if (projection === "orthographic") state.projection = projection;
  }
  const before = opened.look;
  if (look.kind !== before.kind) state.kind = look.kind;
  if (look.shading !== before.shading) state.shading = look.shading;
  const isColouredAlike = look.colourBy === before.colourBy;
  if (!isColouredAlike) state.colourBy = look.colourBy;
  // A field is named wherever an address states that colours show it.
  const isSameField = isColouredAlike && sameValue(look.field, before.field);
  if (look.colourBy === "field" && !isSameField) state.field = look.field;
  if (look.colourMap !== before.colourMap) state.colourMap = look.colourMap;
  if (look.eyeDome !== before.eyeDome) state.eyeDome = look.eyeDome;
  if (!sameValue(look.light, before.light)) state.light = look.light;
  const isSameBackground = opened.isThemeBackground
    ? view.isThemeBackground
    : look.background === before.background;
  if (!isSameBackground) state.background = look.background;
  if (!sameValue({ caps: false, ...clip }, { caps: false, ...opened.clip })) state.clip = clip;
  if (!sameValue(slices, opened.slices)) state.slices = slices;
  if (view.time !== undefined) state.time = view.time;
  const isDefault = overlayParts.every((part) => view.show.has(part) === defaultParts.has(part));
  if (!isDefault) state.show = view.show;
  if (view.layers) {
    const { layers, order } = layersAddress(view.layers);
    if (layers.length > 0) state.layers = layers;
    if (order) state.layerOrder = order;
  }
  if (view.measures) state.measures = view.measures;
  return state;
}

/**
 * Whether the range of the field that colours show is to follow from its values, which have not all arrived. That of
 * a scene may follow later, since its layers may lack the field.
 */
export function awaitsRange({ look, opened }: AddressState): boolean {
  const isOfScene = opened.look.colourBy === "field" && sameValue(look.field, opened.look.field);
  return look.colourBy === "field" && look.field.range === null && !isOfScene;
}

/** Updates the address bar when the view rests, without a new history entry for each change. */
export class AddressBar {
  readonly #view: () => AddressState | null;
  readonly #pendingChanged: () => void;
  readonly #rested: (settings: string, view: AddressState, hasMeasures: boolean) => void;
  #timer = 0;
  #changedAt = 0;

  /**
   * `view`: the current view; null if there is none. `pendingChanged`: see isPending. `rested`:
   * called when the address contains a view: with its settings without measurements, the view, and
   * whether the address contains all measurements and layers. If the measurements do not all fit, the
   * address contains none of them. If the layers do not fit either, it contains no layers.
   */
  constructor(
    view: () => AddressState | null,
    pendingChanged: () => void,
    rested: (settings: string, view: AddressState, hasMeasures: boolean) => void,
  ) {
    this.#rested = rested;
    this.#view = view;
    this.#pendingChanged = pendingChanged;
  }

  /** Whether the address bar does not show the current view yet. */
  get isPending(): boolean {
    return this.#timer !== 0;
  }

  /** The query of the present view without its measurements; null if there is none. */
  get picture(): string | null {
    const view = this.#view();
    return view && writeUrl(addressOf({ ...view, measures: null }));
  }

  /** The query of the present view for another copy of its volume or scene: without added layers, of any length. */
  get settings(): string {
    const view = this.#view();
    if (!view) return "";
    const {
      volume: _,
      scene: __,
      src: ___,
      layers = [],
      layerOrder: ____,
      ...rest
    } = addressOf(view);
    return writeUrl({ ...rest, layers: layers.filter(({ index }) => index !== undefined) });
  }

  changed(): void {
    this.#changedAt = performance.now();
    if (this.isPending) return;
    this.#writeAfter(restMs);
    this.#pendingChanged();
  }

  /** The timer is not restarted for every change, since that is also a browser call. */
  #writeAfter(milliseconds: number): void {
    this.#timer = window.setTimeout(() => {
      const left = this.#changedAt + restMs - performance.now();
      if (left > 0) this.#writeAfter(left);
      else this.write();
    }, milliseconds);
  }

  write(): void {
    clearTimeout(this.#timer);
    this.#timer = 0;
    const view = this.#view();
    if (view) {
      const all = addressOf(view);
      const { measures: _, ...state } = all;
      const { volume: __, scene: ____, src: ___, ...settings } = all;
      const rest = writeUrl(state);
      const whole = writeUrl(all);
      const fits = whole.length <= longestQuery;
      const { layers: _layers, layerOrder: _order, ...picture } = state;
      const query = [whole, rest].find(({ length }) => length <= longestQuery) ?? writeUrl(picture);
      if (query !== location.search) history.replaceState(null, "", location.pathname + query);
      this.#rested(writeUrl(settings), view, fits);
    }
    this.#pendingChanged();
  }
}
