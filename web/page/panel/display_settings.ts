import { defaultParts, type OverlayPart } from "../../overlay/parts.ts";
import type { ShownScene } from "../../scene/open_scene.ts";
import { planeFacing, wholeVolume } from "../../viewer/clipping.ts";
import { distinct, fieldOf } from "../../viewer/field_of.ts";
import { turnedLight } from "../../viewer/light.ts";
import { sameValue } from "../../viewer/same_value.ts";
import { noSlices } from "../../viewer/slices.ts";
import {
  type Clip,
  defaultLook,
  type FieldLook,
  type FieldScale,
  type Look,
} from "../../viewer/types.ts";
import type { Viewer } from "../../viewer/viewer.ts";
import type { AddressState, OpenedPicture } from "../address/page_address.ts";
import type { UrlState } from "../address/url_state.ts";
import { theme, themeBackground } from "../shell/theme.ts";
import type { PageActions, PageState, PictureActions, PictureState } from "./panel_state.ts";
import { withFollowingLines } from "./proposed_lines.ts";

/**
 * The settings of the picture and its overlays: appearance, clipping, slices, parts of the overlay.
 * Starts with the settings of the address. Passes every change to the viewer, which keeps them, and
 * then notifies the page. SurfaceSettings has the surfaces and isovalues.
 */
export class DisplaySettings {
  readonly #viewer: Viewer;
  readonly #changed: () => void;
  #isThemeBackground: boolean;
  #opened: OpenedPicture = {
    look: defaultLook,
    isThemeBackground: true,
    clip: wholeVolume,
    slices: noSlices,
  };
  #show: ReadonlySet<OverlayPart>;
  /** The field in the address that was opened. */
  readonly #ofUrl: FieldLook | undefined;

  constructor(viewer: Viewer, url: UrlState, changed: () => void) {
    this.#viewer = viewer;
    this.#changed = changed;
    this.#isThemeBackground = url.background === undefined;
    this.#ofUrl = url.field;
    viewer.setLook({
      kind: url.kind ?? defaultLook.kind,
      shading: url.shading ?? defaultLook.shading,
      colourBy: url.colourBy ?? defaultLook.colourBy,
      colourMap: url.colourMap ?? defaultLook.colourMap,
      field: url.field ?? defaultLook.field,
      light: url.light ?? defaultLook.light,
      eyeDome: url.eyeDome ?? defaultLook.eyeDome,
      background: url.background ?? themeBackground[theme()],
    });
    viewer.setClip(url.clip ?? wholeVolume);
    viewer.setSlices(url.slices ?? noSlices);
    this.#show = url.show ?? defaultParts;
    viewer.on("light", changed);
    viewer.on("progress", () => {
      if (this.#fitField()) changed();
    });
  }

  /**
   * Unless the range of the field is known: that of the values on the surface, when all of them have arrived.
   * Returns whether the look has changed.
   */
  #fitField(): boolean {
    const { look, progress, layers, fieldRange } = this.#viewer;
    const { state } = progress ?? {};
    const isComplete = state === "complete" || state === "limited";
    if (look.colourBy !== "field" || look.field.range || !isComplete) return false;
    if (this.#viewer.legend?.categories) return false; // labels have no range
    const whole = this.#wholeRange(look.field.name);
    const found = fieldRange ? roundedRange(fieldRange, look.field.scale) : whole;
    const { look: opened } = this.#opened;
    if (found) {
      const fitted = { ...look.field, range: distinct(found) };
      const isOpened = sameValue(look.field, opened.field) || sameValue(look.field, this.#ofUrl);
      // An address or a scene states its interval.
      const field = isOpened || !whole ? fitted : withFollowingLines(fitted, look.field, whole);
      // The range is not a choice of the visitor: the address does not have it.
      if (sameValue(look.field, opened.field)) this.#opened.look = { ...opened, field };
      this.#viewer.setLook({ field });
      return true;
    }
    // Hidden layers and other steps of a scene may have the field.
    if (opened.colourBy === "field" || layers.some(({ info }) => !info)) return false;
    // No store has the field that an address names.
    this.#viewer.setLook({ colourBy: defaultLook.colourBy });
    return true;
  }

  /** Takes over the settings of the scene that was opened, except those in the address. Null if a store was opened. */
  opened(scene: Pick<ShownScene, "document"> | null): void {
    if (!scene) return;
    const { look, background, clip, slices } = scene.document;
    this.#opened = {
      look: { ...defaultLook, ...look, ...(background && { background: background.slice(0, 7) }) },
      isThemeBackground: background === null,
      clip,
      slices,
    };
    if (background !== null) this.#isThemeBackground = false;
  }

  themeChanged(): void {
    if (this.#isThemeBackground) this.#changeLook({ background: themeBackground[theme()] });
  }

  get state(): Omit<PictureState, "projection"> &
    Pick<PageState, "show"> &
    Pick<AddressState, "opened"> {
    return {
      look: this.#viewer.look,
      isThemeBackground: this.#isThemeBackground,
      clip: this.#viewer.clip,
      slices: this.#viewer.slices,
      opened: this.#opened,
      show: this.#show,
    };
  }

  /** Restores earlier settings, for undo and redo. */
  restore(
    view: Pick<AddressState, "look" | "isThemeBackground" | "clip" | "slices" | "show">,
  ): void {
    this.#show = view.show;
    this.#isThemeBackground = view.isThemeBackground;
    this.#viewer.setLook(view.look);
    this.#viewer.setClip(view.clip);
    this.#viewer.setSlices(view.slices);
    this.#changed();
    this.themeChanged();
  }

  readonly actions: Omit<PictureActions, "lookAlong" | "fit" | "toggleProjection"> &
    Pick<PageActions, "toggleShown"> = {
    changeLook: (change) => {
      if (change.background !== undefined) this.#isThemeBackground = false;
      this.#changeLook(change);
    },
    changeLight: (change) => this.#changeLook({ light: { ...this.#viewer.look.light, ...change } }),
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
    changeClip: (change) => this.#setClip(change(this.#viewer.clip)),
    cutAcrossView: () => {
      const { camera, info, clip } = this.#viewer;
      if (camera && info) this.#setClip({ ...clip, planes: [planeFacing(camera, info)] });
    },
    changeSlices: (change) => {
      this.#viewer.setSlices(change(this.#viewer.slices));
      this.#changed();
    },
    sliceAcrossView: () => {
      const { camera, info } = this.#viewer;
      if (!camera || !info) return;
      const plane = planeFacing(camera, info);
      this.actions.changeSlices((now) => ({ ...now, plane }));
    },
  };

  #setClip(clip: Clip): void {
    this.#viewer.setClip(clip);
    this.#changed();
  }

  /** That of the field of the first layer that has it. */
  #wholeRange(name: string): [number, number] | undefined {
    const { layers } = this.#viewer;
    return layers.flatMap(({ info }) => (info && fieldOf(info, name)) ?? [])[0]?.range;
  }

  #changeLook(change: Partial<Look>): void {
    const { field } = change;
    const whole = field && this.#wholeRange(field.name);
    const following = field && whole && withFollowingLines(field, this.#viewer.look.field, whole);
    this.#viewer.setLook(following ? { ...change, field: following } : change);
    this.#fitField();
    this.#changed();
  }
}

/** A range that contains this one, with ends of few digits. */
function roundedRange([low, high]: readonly [number, number], scale: FieldScale): [number, number] {
  const stepOf = (size: number) => 10 ** (Math.floor(Math.log10(size || 1)) - 2);
  const rounded = (value: number, round: (steps: number) => number) => {
    const step = stepOf(scale === "logarithmic" ? Math.abs(value) : high - low);
    return Number((round(value / step) * step).toPrecision(12));
  };
  return [rounded(low, Math.floor), rounded(high, Math.ceil)];
}
