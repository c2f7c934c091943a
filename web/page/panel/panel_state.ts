import type { StoreInfo } from "../../core/types.ts";
import type { OverlayPart } from "../../overlay/parts.ts";
import type { AxisView } from "../../viewer/camera_views.ts";
import type { Light } from "../../viewer/light.ts";
import type { Clip, Look, Projection, Slices, Surface } from "../../viewer/types.ts";
import type { IsovalueScale } from "./isovalue_scale.ts";

/** What the panel shows of the volume: its surfaces and their isovalues. */
export interface VolumeState {
  info: StoreInfo;
  scale: IsovalueScale;
  surfaces: readonly Surface[];
  /** Index of the surface that the slider changes. */
  active: number;
  histogram: HTMLElement;
  isLogarithmic: boolean;
  /** What the visitor is typing into the field of the isovalue, until it is entered or left. */
  typed: string | undefined;
  isSweeping: boolean;
  sweepSeconds: number;
  /** Of the active surface's isovalue, at the finest level; undefined if it is not known. */
  bytes: number | undefined;
}

/** What the panel shows of the picture: look, projection, clipping and slices. */
export interface PictureState {
  look: Look;
  /** The background colour follows the theme. */
  isThemeBackground: boolean;
  clip: Clip;
  slices: Slices;
  projection: Projection | undefined;
}

/** What the panel shows of the page. */
export interface PageState {
  /** What lies above the picture. */
  show: ReadonlySet<OverlayPart>;
  canUndo: boolean;
  canRedo: boolean;
}

export interface PanelState extends VolumeState, PictureState, PageState {}

/**
 * Changes of the surfaces and their isovalues. Settings may have changed since the panel was drawn: an
 * action changes those of now, and ignores a surface that is gone.
 */
export interface VolumeActions {
  /** From the slider: rounded to the scale. */
  slide(value: number): void;
  /** From the number field: not rounded, limited to the range. */
  enter(value: number): void;
  toggleLogarithmic(): void;
  /** Starts or stops to move the isovalue through its range. */
  toggleSweep(): void;
  /** Stops a sweep. The field shows this text, whatever else changes; undefined: the isovalue. */
  type(text: string | undefined): void;
  setSweepSeconds(seconds: number): void;
  activate(index: number): void;
  changeSurface(index: number, change: Partial<Surface>): void;
  addSurface(): void;
  /** Offers the active surface as a file of triangles. */
  saveSurface(): void;
  removeSurface(index: number): void;
}

/** Changes of the picture as it is now, which may not be drawn in the panel yet. */
export interface PictureActions {
  changeLook(change: Partial<Look>): void;
  changeLight(change: Partial<Light>): void;
  /** Turns the key light from where it is now. */
  turnLight(rightDegrees: number, upDegrees: number): void;
  followTheme(): void;
  /** Turns to a view along an axis. */
  lookAlong(view: AxisView): void;
  /** Moves so that the whole volume is seen, without turning. */
  fit(): void;
  /** Between perspective and orthographic. */
  toggleProjection(): void;
  changeClip(change: (now: Clip) => Clip): void;
  /** Replaces the clip plane by one across the view. */
  cutAcrossView(): void;
  changeSlices(change: (now: Slices) => Slices): void;
  /** Replaces the oblique slice by one across the view. */
  sliceAcrossView(): void;
}

/** Changes of the page. */
export interface PageActions {
  /** Shows or hides what lies above the picture. */
  toggleShown(part: OverlayPart): void;
  /** Whether the faces of the clip box have handles in the picture. */
  showClipHandles(isShown: boolean): void;
  /** Saves the picture without its background. */
  saveTransparent(): void;
  openCapture(): void;
  /** Take back, or repeat, the last change of the view. */
  undo(): void;
  redo(): void;
}

export interface PanelActions extends VolumeActions, PictureActions, PageActions {}
