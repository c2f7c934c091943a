import type { Bins, StoreInfo } from "../../core/types.ts";
import type { OverlayPart } from "../../overlay/parts.ts";
import type { AxisView } from "../../viewer/camera_views.ts";
import type { Light } from "../../viewer/light.ts";
import type { Clip, Look, Projection, Slices, Surface } from "../../viewer/types.ts";
import type { ChoicesState } from "./choices_part.ts";
import type { IsovalueScale } from "./isovalue_scale.ts";

/** The state of the volume in the panel: its surfaces and their isovalues. */
export interface VolumeState {
  info: StoreInfo;
  /** The title of the layer, if there are several. */
  title?: string | undefined;
  scale: IsovalueScale;
  surfaces: readonly Surface[];
  /** Index of the surface that the slider changes. */
  active: number;
  histogram: HTMLElement;
  isLogarithmic: boolean;
  /** The unfinished text in the field of the isovalue, until it is entered or the field is left. */
  typed: string | undefined;
  isSweeping: boolean;
  sweepSeconds: number;
  /** The isovalues to choose from, and their pictures. */
  offered: Pick<ChoicesState, "choices" | "pictures">;
  /** Bytes for the active surface's isovalue, at the finest level; undefined if unknown. */
  bytes: number | undefined;
  /** How often the field's values occur on the surface at rest; undefined if no field is shown. */
  fieldBins: Bins | undefined;
  /** The values of the field that colours show are labels. */
  hasLabels: boolean;
}

/** The state of the picture in the panel: look, projection, clipping and slices. */
export interface PictureState {
  look: Look;
  /** Whether the background colour follows the theme. */
  isThemeBackground: boolean;
  clip: Clip;
  slices: Slices;
  projection: Projection | undefined;
}

/** The state of the page in the panel. */
export interface PageState {
  /** The overlays above the picture. */
  show: ReadonlySet<OverlayPart>;
  /** Whether the page shows one volume, whose spacing can be entered if its file states none. */
  mayEnterSpacing: boolean;
  canUndo: boolean;
  canRedo: boolean;
}

export interface PanelState extends VolumeState, PictureState, PageState {}

/**
 * Changes of the surfaces and their isovalues. Settings may have changed since the panel was drawn:
 * an action changes the present ones, and ignores a surface that was removed.
 */
export interface VolumeActions {
  /** From the slider: rounded to the scale. */
  slide(value: number): void;
  /** From the number field: not rounded, limited to the range. */
  enter(value: number): void;
  toggleLogarithmic(): void;
  /** Starts or stops a sweep of the isovalue through its range. */
  toggleSweep(): void;
  /**
   * Stops a sweep. The field shows this text until the next call. With undefined, it shows the
   * isovalue.
   */
  type(text: string | undefined): void;
  setSweepSeconds(seconds: number): void;
  activate(index: number): void;
  changeSurface(index: number, change: Partial<Surface>): void;
  addSurface(): void;
  /** Offers the active surface as a file of triangles. */
  saveSurface(): void;
  removeSurface(index: number): void;
}

/** Changes of the present picture, which the panel may not show yet. */
export interface PictureActions {
  changeLook(change: Partial<Look>): void;
  changeLight(change: Partial<Light>): void;
  /** Turns the key light from its present direction. */
  turnLight(rightDegrees: number, upDegrees: number): void;
  followTheme(): void;
  /** Turns to a view along an axis. */
  lookAlong(view: AxisView): void;
  /** Moves so that the whole volume is visible, without turning. */
  fit(): void;
  /** Switches between perspective and orthographic. */
  toggleProjection(): void;
  changeClip(change: (now: Clip) => Clip): void;
  /** Replaces the clip plane by one perpendicular to the view. */
  cutAcrossView(): void;
  changeSlices(change: (now: Slices) => Slices): void;
  /** Replaces the oblique slice by one perpendicular to the view. */
  sliceAcrossView(): void;
}

/** Changes of the page. */
export interface PageActions {
  /** Shows or hides an overlay above the picture. */
  toggleShown(part: OverlayPart): void;
  /** Shows or hides handles at the faces of the clip box. */
  showClipHandles(isShown: boolean): void;
  /** Saves the picture without its background. */
  saveTransparent(): void;
  /** Asks for the distances between voxels. */
  enterSpacing(): void;
  openCapture(): void;
  /** Undo or redo the last change of the view. */
  undo(): void;
  redo(): void;
}

export interface PanelActions extends VolumeActions, PictureActions, PageActions {}
